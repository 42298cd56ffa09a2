"""Finalists on both sides of a limit that binds, and a search that aims inside it, on made-up evaluations."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from objectives.evaluator import Evaluation
from objectives.metrics import parse
from objectives.problem import Constraint, Objective
from objectives.risk import Risk
from plant.seeds import generator
from tuner.experiments.tuning.active_limits import BackOff, beside_limits, standard_excess
from tuner.experiments.tuning.finalists import MAX_NEAR_BEST, around_limits
from tuner.search.front import feasible_front

MEAN, FLIGHTS = Risk("mean"), 8
ERROR, TRAVEL = Objective(parse("itae.position"), MEAN), Objective(parse("travel"), MEAN)
OVERSHOOT = Constraint(Objective(parse("overshoot.x"), MEAN), 15.0, confidence=0.95)


def evaluated(values, limited, constraint=OVERSHOOT, spread=1.0, known=None, flights=FLIGHTS) -> Evaluation:
    """An evaluation of objectives (n, m) and means (n,) of a limited quantity, whose flights share their air."""
    values, limited = np.atleast_2d(np.array(values, dtype=float).T).T, np.array(limited, dtype=float)
    n, m = values.shape
    air = generator(2, "test/active-limits", 0).standard_normal(flights)
    air = (air - air.mean()) / air.std()
    scores = np.concatenate(
        [np.repeat(values[..., None], flights, axis=2), limited[:, None, None] + spread * air], axis=1
    )
    beyond = np.zeros((n, 0)) if known is None else np.array(known, dtype=float)[:, None]
    excess = np.concatenate([(limited - constraint.most)[:, None], beyond], axis=1)
    return Evaluation(values, excess, np.zeros(n), scores, np.repeat("gusts", flights), beyond, np.ones(n, dtype=bool))


def test_excess_counts_in_distances_to_the_end_of_an_interval():
    seen = evaluated([1.0, 2.0, 3.0], [15.0, 14.0, 16.0])
    at, inside, outside = standard_excess(seen, (OVERSHOOT,), 1)
    assert at == 0.0 and inside < 0.0 < outside
    # Twice the spread, half the excess.
    wider = evaluated([1.0, 2.0, 3.0], [15.0, 14.0, 16.0], spread=2.0)
    assert standard_excess(wider, (OVERSHOOT,), 1)[1:] == pytest.approx([0.5 * inside, 0.5 * outside], rel=1e-9)


@pytest.mark.parametrize(
    "constraint",
    [
        Constraint(Objective(parse("failure"), MEAN), 0.0),
        Constraint(Objective(parse("overshoot.x"), Risk("worst")), 15.0),
        Constraint(Objective(parse("overshoot.x"), MEAN), 15.0, floor="mission.followed"),
    ],
)
def test_a_limit_without_an_error_of_its_own_has_no_tolerance(constraint):
    most = constraint.most
    excess = standard_excess(evaluated([1.0, 1.0], [most, most + 0.01], constraint), (constraint,), 1)
    assert excess.tolist() == [-np.inf, np.inf]


def test_behind_a_back_off_excess_counts_from_where_a_whole_interval_keeps_the_limit():
    seen = evaluated([1.0, 2.0, 3.0], [15.0, 14.0, 16.0])
    back_off = BackOff(np.array([2.0]), np.array([0.5]))
    assert standard_excess(seen, (OVERSHOOT,), 1, back_off).tolist() == [4.0, 2.0, 6.0]
    unknown = BackOff(np.array([np.nan]), np.array([np.nan]))
    assert np.array_equal(standard_excess(seen, (OVERSHOOT,), 1, unknown), standard_excess(seen, (OVERSHOOT,), 1))


def test_requirements_have_no_tolerance():
    assert standard_excess(evaluated([1.0], [10.0], known=[1e-9]), (OVERSHOOT,), 1)[0] == np.inf


def along_a_limit(count=41):
    """Candidates of one objective that cost more the further inside a limit they are; from 12 to 18."""
    limited = np.linspace(12.0, 18.0, count)
    return evaluated(30.0 - limited, limited)


def test_of_one_objective_finalists_stand_on_both_sides_of_the_limit():
    seen = along_a_limit()
    best = feasible_front(seen.values, seen.violations)
    assert len(best) == 1
    rows = beside_limits(seen, (OVERSHOOT,), best, 1, 15)
    limited, excess = seen.excess[rows, 0], standard_excess(seen, (OVERSHOOT,), 1)[rows]
    assert len(rows) >= 7 and not np.isin(rows, best).any() and len(set(rows.tolist())) == len(rows)
    assert np.sum(limited > 0.0) >= 3 and np.sum(limited < 0.0) >= 3 and np.all(excess <= 1.0)


def test_an_objective_alone_has_further_finalists_where_no_limit_binds():
    seen = evaluated(np.arange(20.0) + 1.0, np.full(20, 2.0))
    assert beside_limits(seen, (OVERSHOOT,), np.array([0]), 1, 7).tolist() == [1, 2, 3, 4, 5, 6, 7]


def test_a_front_far_within_its_limits_has_no_others_beside_it():
    error = np.linspace(1.0, 2.0, 9)
    seen = evaluated(np.stack([error, 3.0 - error], axis=1), np.full(9, 2.0))
    assert not len(beside_limits(seen, (OVERSHOOT,), np.arange(9), 1, 8))


def test_what_only_a_race_ended_is_no_finalist():
    seen = along_a_limit()
    raced = replace(seen, counted=np.where(np.arange(41) % 2, 4, FLIGHTS))
    assert np.all(beside_limits(raced, (OVERSHOOT,), np.array([], dtype=int), 1, 20) % 2 == 0)


def test_finalists_at_a_limit_go_by_fresh_flights_and_by_the_searchs_own():
    seen = along_a_limit()
    study: Any = SimpleNamespace(constraints=(OVERSHOOT,), seed=1, objectives=(ERROR,))
    nothing, far = np.array([], dtype=int), BackOff(np.array([2.0]), np.array([0.2]))
    unknown = BackOff(np.array([np.nan]), np.array([np.nan]))
    own = beside_limits(seen, (OVERSHOOT,), nothing, 1, MAX_NEAR_BEST)
    assert np.array_equal(around_limits(seen, study, nothing, unknown), own)
    assert np.array_equal(around_limits(seen, study, nothing, None), own)
    limited = seen.excess[around_limits(seen, study, nothing, far), 0]
    # Fresh flights put the limit at -2, the search's own at 0: each side of both has finalists, none of them twice.
    assert len(limited) == len(set(limited.tolist())) == MAX_NEAR_BEST
    assert np.sum(np.abs(limited + 2.0) < 0.5) >= 4 and np.sum(np.abs(limited) < 0.7) >= 4
