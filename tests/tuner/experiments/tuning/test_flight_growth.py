"""Flights of a search that grow: by fresh flights that disagree, and to the same bits whenever the run is made again."""

import numpy as np
import pandas as pd
import pytest

from objectives.risk import Risk
from plant.errors import InputError
from tests.tables import read_frame
from tests.tuner.conftest import run_small
from tests.tuner.experiments.again.killing import compare, result_of
from tuner.experiments.again.resume import resume
from tuner.experiments.again.verify import verify
from tuner.experiments.tuning import flight_growth
from tuner.search.watcher import Watcher

GROWING = {
    "search": {"population": 8, "generations": 6},
    "scenario__0__search": 32,
    "scenario__0__held_out": 32,
    "scenario__0__duration": 1.0,
    "scenario__0__reference__time": 0.1,
    "margin": [],
    "mission__off": ["rms.position", "rms.yaw"],
}


@pytest.fixture(scope="module")
def grown(tmp_path_factory):
    """A run whose fresh flights count as worse than the search's whatever they are, at the one check that it has."""
    folder = tmp_path_factory.mktemp("growth") / "run"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(flight_growth, "MAX_RATIO", 0.0)
        yield run_small(folder, **GROWING), folder


def flights_each(outcome):
    return [entry.evaluation.scores.shape[-1] for entry in outcome.generations]


@pytest.mark.slow
def test_all_candidates_make_the_further_flights(grown):
    outcome, folder = grown
    assert flights_each(outcome) == [16] * 6
    # At the fourth generation all had made 8, and made 8 more; the two after it made 16 at once.
    flights = pd.read_csv(folder / "history.csv").flights.tolist()
    assert flights == [64, 128, 192, 512, 640, 768]


def test_values_are_those_of_all_flights(grown):
    outcome, _ = grown
    for generation in outcome.generations:
        scores = generation.evaluation.scores[:, 0]
        assert np.array_equal(generation.evaluation.values[:, 0], Risk("cvar", 0.8).apply(scores))


def test_tables_on_disk_hold_them(grown):
    outcome, folder = grown
    for generation in outcome.generations:
        table = read_frame(folder / "generations" / f"{generation.number:04d}.npz")
        values = table[[name for name in table if name.startswith("objective:")]].to_numpy()
        assert np.array_equal(values, generation.evaluation.values)


@pytest.mark.slow
def test_the_same_bits_again_on_another_number_of_threads_and_after_a_stop(grown, tmp_path):
    _, folder = grown
    assert verify(folder, 3, 2, Watcher()).identical
    whole = result_of(folder)
    for file in (folder / "flights").glob("growth-*"):
        file.unlink()
    (folder / "summary.json").unlink()
    resume(folder, Watcher(), threads=1)
    compare(result_of(folder), whole)


def test_flights_that_agree_stay(tmp_path, monkeypatch, no_pictures):
    monkeypatch.setattr(flight_growth, "MAX_RATIO", 1e9)
    assert flights_each(run_small(tmp_path / "run", **GROWING)) == [8] * 6


def test_a_number_that_the_study_gives_stays(tmp_path, monkeypatch, no_pictures):
    monkeypatch.setattr(flight_growth, "MAX_RATIO", 0.0)
    changes = {**GROWING, "search": {**GROWING["search"], "first": 8}}
    assert flights_each(run_small(tmp_path / "run", **changes)) == [8] * 6


@pytest.mark.slow
def test_a_run_that_gets_more_flights_ends_as_one_that_had_them(tmp_path, monkeypatch):
    monkeypatch.setattr(flight_growth, "MAX_RATIO", 0.0)
    folder = tmp_path / "run"
    assert flights_each(run_small(folder, **{**GROWING, "scenario__0__search": 8})) == [8] * 6
    resumed = resume(folder, Watcher(), search_flights=16, threads=1)
    assert flights_each(resumed.outcome) == [16] * 6
    run_small(tmp_path / "fresh", **{**GROWING, "scenario__0__search": 16})
    for name in ("front.csv", "generations/0005.npz"):
        assert (folder / name).read_bytes() == (tmp_path / "fresh" / name).read_bytes()
    assert verify(folder, 3, 2, Watcher()).identical
    # To the end of the run, and of another one after it.
    assert flights_each(resume(folder, Watcher()).outcome) == [16] * 6
    with pytest.raises(InputError, match=r"--search-flights: given 8 flights; the search made up to 16"):
        resume(folder, Watcher(), search_flights=8)
