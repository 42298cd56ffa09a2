"""Finalists where limits known without flying are looked at in all states at the end alone, on made-up evaluations."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from objectives.requirements import Requirement, Screen
from tests.tuner.experiments.tuning.test_active_limits import OVERSHOOT, evaluated
from tuner.experiments.tuning import finalists
from tuner.experiments.tuning.finalists import finalists_in_all_states, finalists_of
from tuner.experiments.tuning.survivors import Survivors

COUNT = 60
MAX_PEAK = 2.0


def posed(further: float):
    """Candidates that are the better the closer they are to a limit on Ms; in its last state each has `further` more of it."""
    ms = np.linspace(1.5, MAX_PEAK, COUNT)
    requirement: Any = Requirement("ms", "peak sensitivity", "1", MAX_PEAK, "max")
    screen = Screen((requirement,), lambda gains: gains, complete=lambda gains: gains + further)
    evaluation = evaluated(10.0 - ms, np.full(COUNT, 5.0), known=requirement.excess(ms))
    problem: Any = SimpleNamespace(
        requirements=(requirement,), screens=(screen,), space=SimpleNamespace(gains=lambda points: points)
    )
    search = SimpleNamespace(candidates=COUNT)
    study: Any = SimpleNamespace(
        search=search, constraints=(OVERSHOOT,), requirements=(requirement,), objectives=(None,), seed=1, scenarios=()
    )
    tried: Any = SimpleNamespace(points=ms[:, None])
    return problem, Survivors(np.arange(COUNT), evaluation, 0), tried, study


@pytest.fixture(autouse=True)
def _quiet(monkeypatch):
    monkeypatch.setattr(finalists, "warnings_before_run", lambda _: [])


def test_where_all_that_are_best_break_a_margin_in_its_last_state_those_behind_them_are_finalists():
    problem, survivors, tried, study = posed(0.2)
    nearest, _ = finalists_of(survivors, tried, study)
    assert np.all(tried.points[nearest] + 0.2 > MAX_PEAK)
    chosen, _ = finalists_in_all_states(problem, survivors, tried, study)
    kept = tried.points[chosen, 0] + 0.2 <= MAX_PEAK
    assert kept.all() and len(chosen) == len(nearest)
    # The best of all that keep it is among them.
    assert tried.points[chosen].max() == tried.points[tried.points + 0.2 <= MAX_PEAK].max()


def test_where_some_keep_it_or_none_can_they_are_those_of_the_search():
    for further in (0.0, 0.01, 1.0):
        problem, survivors, tried, study = posed(further)
        chosen, _ = finalists_in_all_states(problem, survivors, tried, study)
        assert chosen.tolist() == finalists_of(survivors, tried, study)[0].tolist()
