"""Finalists stop where their place is settled and nowhere else, and what is said of them then is true and wide enough."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from objectives.flown_system import FlightBatch
from objectives.problem import Constraint, Objective, Problem
from objectives.risk import Risk
from plant.seeds import generator
from tuner.analysis.final_flights import FinalFlights
from tuner.analysis.finals import Finals
from tuner.search.front import non_dominated, pick

FLIGHTS, EARLY = 256, 64
MEAN = Risk("mean")


def measured(text, is_binary=False) -> Any:
    """A metric by its name."""
    return SimpleNamespace(text=text, metric=SimpleNamespace(is_binary=is_binary, highest=np.inf))


class Made(Problem):
    """A problem whose flights are given: scores (rows, quantities, flights); a gains row is the number of its row."""

    def __init__(self, scores, constraints=()):
        names = [measured(name) for name in "ab"]
        self.objectives = tuple(Objective(name, MEAN) for name in names)
        self.scores, self.constraints, self.screens, self.flights_made = scores, constraints, (), 0

    def chunks(self, batch):
        return [(0, batch.count)] if batch.count <= 100 else [(0, 100), (100, batch.count)]

    def scored(self, gains, flown, batch, first, last, on_flights_done=None):
        self.flights_made += len(gains) * (last - first)
        return self.scores[gains[:, 0].astype(int), :, first:last], np.zeros((len(gains), last - first), dtype=bool)


def knee(values, feasible):
    """The default comes first and is never recommended."""
    rows = 1 + np.flatnonzero(feasible[1:])
    rows = rows[non_dominated(values[rows])] if len(rows) else rows
    return int(rows[pick("knee", values[rows], ["a", "b"])[0]]) if len(rows) else 0


def fly(scores, constraints=(), count=FLIGHTS, told=None):
    problem, spec = Made(scores, constraints), SimpleNamespace(name="gusts")
    gains = np.arange(len(scores), dtype=float)[:, None]
    batch: Any = FlightBatch(spec, "held-out", count)  # pyright: ignore[reportArgumentType]
    return Finals(problem, gains, (batch,), knee, 1, told).fly(), problem


def table(centres, noise=0.05, own=0.0, key=0):
    """Scores (rows, 2, flights) around centres (rows, 2): the air is the same for all rows, `own` is each row's."""
    draw, shape = generator(1, "test/finals", key), (len(centres), 2, FLIGHTS)
    air = draw.standard_normal((1, 2, FLIGHTS))
    return np.array(centres, dtype=float)[..., None] + noise * air + own * draw.standard_normal(shape)


# The default; a front with its knee in row 3; a row that row 3 dominates.
FRONT = [(20.0, 20.0), (1.0, 9.0), (2.0, 5.0), (3.0, 3.0), (5.0, 2.0), (9.0, 1.0), (4.0, 4.0)]


def test_who_is_surely_on_the_front_or_off_it_stops_but_for_the_default_and_the_recommended():
    found, problem = fly(table(FRONT, own=0.01))
    # Rows 1 and 4 fly on for the knee's sake: without rows 1 and 2, which may yet lose a flight, it would be row 4.
    assert found.complete.tolist() == [True, True, False, True, True, False, False]
    assert found.evaluation.flights == problem.flights_made == 4 * FLIGHTS + 3 * EARLY
    assert found.non_dominated(np.arange(1, 7)).tolist() == [True] * 5 + [False]
    assert not found.evaluation.complete[2] and found.evaluation.flights_each[2] == EARLY


def test_two_that_are_even_in_one_objective_go_on():
    # Row 2 is better than its twin in b; which of the two is better in a is open.
    found, _ = fly(table([*FRONT[:-1], (2.0, 5.2)], own=0.05))
    assert found.complete.tolist() == [True, False, True, True, True, False, True]


def test_a_constraint_that_some_resamples_break_is_flown_to_its_end():
    metric = measured("c")
    limited, scores = (Constraint(Objective(metric, MEAN), 0.1),), table(FRONT, own=0.01)
    share = np.zeros((len(FRONT), 1, FLIGHTS))
    # Row 1 breaks it surely, row 2 perhaps: 8 of 64 flights are 0.125. Without both, row 4 is the knee of what is left.
    share[1, 0], share[2, 0, :EARLY:8] = 1.0, 1.0
    found, _ = fly(np.concatenate([scores, share], axis=1), limited)
    assert found.complete.tolist() == [True, False, True, True, True, False, False]
    assert (found.evaluation.violations[:, 0] > 0.0).tolist() == [False, True, False, False, False, False, False]


def test_without_anyone_who_keeps_the_limits_all_fly_everything():
    metric = measured("c")
    scores = np.concatenate([table(FRONT), np.ones((len(FRONT), 1, FLIGHTS))], axis=1)
    found, _ = fly(scores, (Constraint(Objective(metric, MEAN), 0.5),))
    assert found.complete.all()


def test_few_flights_are_all_made():
    scores, told = table(FRONT), []
    found, problem = fly(scores, count=100, told=told.append)
    assert found.complete.all() and problem.flights_made == 100 * len(FRONT)
    np.testing.assert_allclose(found.evaluation.values, scores[..., :100].mean(axis=-1), rtol=1e-14)


def test_flights_that_are_not_made_count_as_done():
    told = []
    _, problem = fly(table(FRONT, own=0.01), told=told.append)
    assert problem.flights_made + sum(told) == FLIGHTS * len(FRONT)


def test_where_the_air_alone_makes_the_difference_the_value_is_that_of_all_flights():
    scores = table(FRONT, noise=0.5)
    found, _ = fly(scores)
    stopped = ~found.complete
    assert stopped.any()
    truth = scores.mean(axis=-1)
    np.testing.assert_allclose(found.evaluation.values[stopped], truth[stopped], rtol=1e-12)
    # On its own flights alone it would be off by more.
    assert np.abs(scores[stopped][..., :EARLY].mean(axis=-1) - truth[stopped]).min(axis=0).max() > 1e-3


@pytest.mark.parametrize("own", [0.2, pytest.param(2.0, marks=pytest.mark.slow)])
def test_intervals_of_those_that_stopped_hold_the_truth_as_often_as_they_say(own):
    """300 sets of flights of two rows, of which the second stopped: with its own noise below and above that of the air."""
    hits, wider, repeats = 0, 0, 300
    early, complete = np.arange(FLIGHTS) < EARLY, np.array([True, False])
    for key in range(repeats):
        scores = table([(1.0, 1.0), (1.5, 1.5)], noise=1.0, own=own, key=key)
        flown = FinalFlights(
            Made(scores),
            1,
            scores,
            np.zeros((2, FLIGHTS), dtype=bool),
            np.repeat("gusts", FLIGHTS),
            np.zeros((2, 0)),
            early,
            complete,
        )
        _, low, high = flown.estimate(0)
        hits += low[1] <= 1.5 <= high[1]
        wider += high[1] - low[1] > high[0] - low[0]
    # Three standard errors of 0.95 from 300 are 0.038.
    assert hits / repeats > 0.95 - 0.038
    assert wider == repeats or own < 1.0
