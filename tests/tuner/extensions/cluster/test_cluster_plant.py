"""A plant of one's own on workers: the bits of a run without them, and no worker flies code that nobody gave it."""

import pickle
import shutil
from typing import Any

import control
import pytest

from objectives.flown_system import FlightBatch
from objectives.memory import scenario_key
from plant.errors import InputError
from tests.plant.own_files import forget
from tests.tuner.conftest import QUICKSTART
from tests.tuner.experiments.own_motor import PLANT, write_motor
from tests.tuner.extensions.cluster.clusters import scheduler, worker
from tests.tuner.in_process import tuner
from tuner.api.studies import load_study, make_study
from tuner.extensions.cluster.brief import BatchSpec, brief_of, system_of
from tuner.extensions.cluster.own_files import not_here, own_files_of
from tuner.study.plant_study import PlantStudy
from tuner.study.reading import parse_toml
from tuner.text.toml_text import toml_text

pytest.importorskip("distributed", reason="flies on a Dask cluster: pip install distributed")

HEATER = QUICKSTART.parent / "heater.toml"
SHORT = ("--set", "search.generations=2", "--set", "scenario.0.held_out=8", "--set", "scenario.0.search=4")
SHORTER = (*SHORT, "--set", "scenario.1.held_out=8", "--set", "scenario.1.search=4")
SAME = ("front.csv", "gains.json", "responses.npz", "generations/0001.npz")


@pytest.fixture
def motor(tmp_path):
    return write_motor(tmp_path)


def brief(file) -> BatchSpec:
    study = load_study(file, kind=PlantStudy)
    return brief_of(study.system, study.seed, FlightBatch(study.scenarios[0].spec, "search", 4))


@pytest.mark.slow
def test_processes_of_this_machine_leave_what_none_leave(motor, tmp_path, monkeypatch, capsys, no_figures):
    for name, options in (("alone", ()), ("there", ("--dask", "local:2"))):
        code, out, err = tuner(monkeypatch, capsys, "run", motor, "--out", tmp_path / name, *SHORT, *options)
        assert code == 0, err
    assert "Cluster of 2 workers" in out
    for name in SAME:
        assert (tmp_path / "there" / name).read_bytes() == (tmp_path / "alone" / name).read_bytes(), name


def test_a_brief_holds_a_digest_and_numbers_and_its_worker_builds_the_same_loop(motor):
    sent = pickle.dumps(brief(motor))
    assert b"def derivative" not in sent and str(motor.parent).encode() not in sent
    assert list(system_of(pickle.loads(sent)).laws) == ["angle"]


def test_a_worker_without_the_file_is_told_so_in_one_line(motor):
    sent = pickle.dumps(brief(motor))
    (own,) = own_files_of(load_study(motor, kind=PlantStudy).system, [])
    assert not_here([own.digest]) == []
    forget()
    assert not_here([own.digest]) == [own.digest]
    with pytest.raises(
        InputError, match=r"has not been given motor.py \(digest .*\), which is never sent: copy it there"
    ):
        system_of(pickle.loads(sent))


def test_another_version_of_the_file_is_another_file(motor):
    sent = pickle.dumps(brief(motor))
    forget()
    motor.with_name("motor.py").write_text(PLANT.replace("4.0", "5.0"), encoding="utf-8")
    load_study(motor, kind=PlantStudy)
    with pytest.raises(InputError, match=r"has not been given motor.py"):
        system_of(pickle.loads(sent))


def test_a_plant_of_a_notebook_is_on_no_worker(motor):
    import tomllib

    names: dict = {"__name__": "cell"}
    exec(PLANT, names)
    tables = tomllib.loads(motor.read_text(encoding="utf-8"))
    del tables["plant"]["file"]
    study = make_study(tables, "motor", plant=names)
    assert toml_text(tables) == study.text
    with pytest.raises(InputError, match="no file holds the code of this plant"):
        own_files_of(study.system, [])


@pytest.fixture(params=["study", "system of python-control", "state space"])
def linear(request):
    """A study of a linear plant by its numbers, as it is read or made."""
    if request.param == "study":
        return load_study(HEATER, kind=PlantStudy)
    system = control.tf([1.8], [120.0, 23.0, 1.0])
    given = system if request.param != "state space" else control.ss([[-0.2]], [[1.0]], [[0.3]], [[0.0]])
    tables: dict[str, Any] = parse_toml(HEATER)
    tables["plant"] = {key: tables["plant"][key] for key in ("control_period", "inputs", "outputs")}
    for scenario in tables["scenario"]:
        scenario["spread"] = {}
    return make_study(tables, "heater", plant=given, kind=PlantStudy)


def test_a_linear_plant_goes_to_workers_by_its_numbers(linear):
    assert own_files_of(linear.system, [entry.spec for entry in linear.scenarios]) == ()
    batch = FlightBatch(linear.scenarios[0].spec, "search", 4)
    there = system_of(pickle.loads(pickle.dumps(brief_of(linear.system, linear.seed, batch))))
    assert scenario_key(there, linear.seed, batch) == scenario_key(linear.system, linear.seed, batch)


@pytest.mark.slow
def test_processes_fly_a_linear_plant_to_the_same_bits(tmp_path, monkeypatch, capsys, no_figures):
    for name, options in (("alone", ()), ("there", ("--dask", "local:2"))):
        code, _, err = tuner(monkeypatch, capsys, "run", HEATER, "--out", tmp_path / name, *SHORTER, *options)
        assert code == 0, err
    for name in SAME:
        assert (tmp_path / "there" / name).read_bytes() == (tmp_path / "alone" / name).read_bytes(), name


@pytest.mark.slow
def test_workers_elsewhere_fly_once_the_file_is_named_there(motor, tmp_path, monkeypatch, capsys, no_figures):
    there = tmp_path / "there"
    there.mkdir()
    shutil.copy(motor.with_name("motor.py"), there)
    alone = ("run", motor, "--out", tmp_path / "alone", *SHORT)
    assert tuner(monkeypatch, capsys, *alone)[0] == 0
    with scheduler(tmp_path) as (_, address):
        with worker(tmp_path, address):
            code, _, err = tuner(monkeypatch, capsys, "run", motor, "--out", tmp_path / "a", *SHORT, "--dask", address)
            assert code == 2 and "has not been given motor.py" in err and err.count("\n") == 1
        named = ("--preload", "tuner.extensions.cluster.preload", "--code", str(there / "motor.py"))
        with worker(tmp_path, address, "--nthreads", "1", "--no-nanny", *named, name="named"):
            code, _, err = tuner(monkeypatch, capsys, "run", motor, "--out", tmp_path / "b", *SHORT, "--dask", address)
            assert code == 0, err
    for name in SAME:
        assert (tmp_path / "b" / name).read_bytes() == (tmp_path / "alone" / name).read_bytes(), name
