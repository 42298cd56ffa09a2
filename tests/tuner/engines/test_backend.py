"""`tuner run --backend`: which engine flies."""

from types import SimpleNamespace
from typing import Any

import pytest

from plant.errors import InputError, StoreError, UnknownNameError
from tests.plant.loops import LIMITS, NOMINAL, TIMING, VEHICLE, loop
from tests.tuner.in_process import tuner
from tuner.engines import registry as choice
from tuner.store.folder import Folder
from tuner.store.inputs import RunRecord


def test_the_processor_flies_by_default_and_without_a_word():
    assert choice.engine_named("lanes", system(), 1) is None


def test_an_unknown_backend_is_refused_with_the_nearest():
    with pytest.raises(UnknownNameError, match="did you mean 'cuda'.*cuda, cuda-float32, lanes"):
        choice.check("cida")


def test_run_refuses_what_a_card_does_not_fly(monkeypatch, capsys):
    code, _, error = tuner(monkeypatch, capsys, "run", "studies/quickstart.toml", "--backend", "gpu")
    assert code == 2 and "--backend: unknown backend 'gpu'" in error
    code, _, error = tuner(
        monkeypatch, capsys, "run", "studies/quickstart.toml", "--backend", "cuda", "--dask", "local:1"
    )
    assert code == 2 and "give --dask or --backend" in error
    code, _, error = tuner(monkeypatch, capsys, "run", "studies/contest.toml", "--backend", "cuda")
    assert code == 2 and "only a tuning study flies on a graphics card" in error


def test_a_backend_of_another_record_flies_by_its_name_and_what_it_flew(monkeypatch, tmp_path):
    engine = flying("slide-rule, 10 inches")
    backend = choice.Backend("slide-rule,", lambda: None, lambda flown, root: engine)
    monkeypatch.setattr(choice, "added", lambda part: {"slide": "a:B"} if part == "backends" else {})
    monkeypatch.setattr(choice, "load", {"a:B": backend}.__getitem__)
    assert choice.engine_named("slide", system(), 1) is engine
    assert choice.recorded_engine(recorded(tmp_path / "slide", engine.arithmetic), system(), 1) is engine


def test_without_an_extension_the_processor_alone_flies(monkeypatch, tmp_path):
    monkeypatch.setattr(choice, "added", lambda part: {})
    with pytest.raises(UnknownNameError, match="unknown backend 'cuda'.*lanes"):
        choice.engine_named("cuda", system(), 1)
    with pytest.raises(StoreError, match="there is none here"):
        choice.recorded_engine(recorded(tmp_path / "card", "cuda-float32, sm_90"), system(), 1)


def test_a_cluster_is_reached_through_a_record_and_never_replaced_by_this_machine(monkeypatch):
    study: Any = object()
    asked = []
    monkeypatch.setattr(choice, "load", lambda reference: lambda *given: asked.append((reference, *given)))
    with choice.cluster_engine(None, study, None, print) as engine:
        assert engine is None
    choice.cluster_engine("local:2", study, 4, print)
    assert asked == [("tuner.extensions.cluster.connect:engine_at", "local:2", study, 4, print)]
    monkeypatch.setattr(choice, "added", lambda part: {})
    with pytest.raises(InputError, match="--dask: no installed extension connects to a cluster"):
        choice.cluster_engine("local:2", study, None, print)


def system():
    from objectives.system import System

    return System(VEHICLE, loop().cascade, NOMINAL, LIMITS, TIMING)


def recorded(folder, arithmetic):
    """A results folder of which nothing is read but who flew it."""
    made = Folder.create(folder)
    record = RunRecord(
        format="gainproof-run",
        version=1,
        kind="tuning",
        study="inputs/a.toml",
        digest="d",
        generations=3,
        model="m",
        arithmetic=arithmetic,
    )
    made.write_json("run.json", record)
    made.close()
    return folder


def flying(arithmetic: str) -> Any:
    """An engine of which nothing is asked but its arithmetic."""
    return SimpleNamespace(arithmetic=arithmetic)


def test_what_the_processor_flew_it_flies_again(tmp_path):
    cluster = flying("lanes")
    folder = recorded(tmp_path / "lanes", "lanes")
    assert choice.recorded_engine(folder, system(), 1) is None
    assert choice.recorded_engine(folder, system(), 1, cluster) is cluster


def test_another_arithmetic_is_never_mixed_in(monkeypatch, tmp_path):
    """A run of a card goes on with the same card, compiler and driver or not at all."""
    flown = "cuda-float32, sm_90, numba-cuda 0.30.4, CUDA 13.0"
    folder = recorded(tmp_path / "card", flown)
    monkeypatch.setattr(choice, "engine_named", lambda *_: None)
    with pytest.raises(StoreError, match="sm_90.*there is none here"):
        choice.recorded_engine(folder, system(), 1)
    other = flying(flown.replace("sm_90", "sm_80"))
    monkeypatch.setattr(choice, "engine_named", lambda *_: other)
    with pytest.raises(StoreError, match="here it is cuda-float32, sm_80"):
        choice.recorded_engine(folder, system(), 1)
    with pytest.raises(StoreError, match="leave --dask out"):
        choice.recorded_engine(folder, system(), 1, flying("lanes"))
    same = flying(flown)
    monkeypatch.setattr(choice, "engine_named", lambda backend, *_: same if backend == "cuda-float32" else None)
    assert choice.recorded_engine(folder, system(), 1) is same
