"""Flights that everyone loses count for nobody; all others do."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from objectives.flown_system import FlightBatch
from objectives.metrics import parse
from objectives.problem import Constraint, Evaluation, Objective, Problem
from objectives.risk import Risk
from tuner.analysis import air_losses as air
from tuner.analysis.air_losses import air_losses, excused_evaluation

MEAN, FLIGHTS, ROWS = Risk("mean"), 64, 4


class Known(Problem):
    """A problem that is asked for risks alone."""

    def __init__(self):
        self.objectives = (Objective(parse("itae.position"), MEAN),)
        self.constraints, self.screens = (Constraint(Objective(parse("failure"), MEAN), 0.0),), ()


def batch(count=FLIGHTS, name="gusts", start=0) -> Any:
    return FlightBatch(SimpleNamespace(name=name), "held-out", count, start)  # pyright: ignore[reportArgumentType]


def found(monkeypatch, lost, suspects, batches=None, rows=ROWS):
    """The flights that the air lost, where `lost` (rows, flights) says who loses which of all scenarios in a row."""
    batches = batches or (batch(),)
    first = np.cumsum([0, *[entry.count for entry in batches]])

    def is_lost(_, row, entry, numbers):
        return lost[int(row[0]), first[batches.index(entry)] + np.array(numbers)]

    monkeypatch.setattr(air, "is_lost", is_lost)
    mask = np.zeros(int(first[-1]), dtype=bool)
    mask[suspects] = True
    return np.flatnonzero(air_losses(Known(), np.arange(rows, dtype=float)[:, None], batches, mask)).tolist()


def test_only_what_every_point_loses_is_the_airs(monkeypatch):
    lost = np.zeros((ROWS, FLIGHTS), dtype=bool)
    lost[:, 19], lost[1:, 20] = True, True
    assert found(monkeypatch, lost, [19, 20]) == [19]
    assert found(monkeypatch, lost, []) == []


def test_flights_are_known_by_their_scenario(monkeypatch):
    lost = np.zeros((ROWS, 2 * FLIGHTS), dtype=bool)
    lost[:, FLIGHTS + 5] = True
    assert found(monkeypatch, lost, [5, FLIGHTS + 5], (batch(), batch(name="calm"))) == [FLIGHTS + 5]


def test_two_points_may_share_a_weakness_and_many_losses_are_the_studys(monkeypatch):
    lost = np.ones((ROWS, FLIGHTS), dtype=bool)
    assert found(monkeypatch, lost, [3], rows=2) == []
    # A twentieth of 64 flights is 3.
    assert found(monkeypatch, lost, [1, 2, 3]) == [1, 2, 3]
    assert found(monkeypatch, lost, [1, 2, 3, 4]) == []


def test_who_makes_no_flights_here_has_no_air():
    problem: Any = SimpleNamespace()
    assert not air_losses(problem, np.zeros((ROWS, 1)), (batch(),), np.eye(1, FLIGHTS, dtype=bool)[0]).any()


@pytest.mark.parametrize("lost", [[7], [7, 9]])
def test_values_are_those_of_the_other_flights(lost):
    draw = np.random.default_rng(1)
    scores, failed, mask = (
        draw.uniform(1.0, 2.0, (2, 2, FLIGHTS)),
        np.zeros((2, FLIGHTS), dtype=bool),
        np.zeros(FLIGHTS),
    )
    scores[:, 1], mask = 0.0, np.isin(np.arange(FLIGHTS), lost)
    scores[:, 0, lost], scores[:, 1, lost], failed[:, lost] = 1e4, 1.0, True
    # One flight more that the second point loses alone.
    scores[1, 1, 30], failed[1, 30] = 1.0, True
    problem = Known()
    risks = problem.risks(scores, np.repeat("gusts", FLIGHTS))
    seen = Evaluation(
        risks[:, :1],
        risks[:, 1:],
        failed.mean(axis=-1),
        scores,
        np.repeat("gusts", FLIGHTS),
        np.zeros((2, 0)),
        np.ones(2, dtype=bool),
        failed=failed,
    )
    excused = excused_evaluation(problem, seen, mask)
    assert excused.values[:, 0] == pytest.approx(scores[:, 0, ~mask].mean(axis=-1), rel=1e-12)
    assert excused.excess[0, 0] == 0.0 and excused.excess[1, 0] == 1.0 / FLIGHTS
    assert excused.lost.tolist() == [0, 1]
    assert excused_evaluation(problem, seen, np.zeros(FLIGHTS, dtype=bool)) is seen
