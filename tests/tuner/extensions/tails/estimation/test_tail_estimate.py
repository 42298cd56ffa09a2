"""Estimates of tails against closed forms, resumed runs, and every way to end."""

import numpy as np
import pytest
from scipy.stats import norm

from benchmarks.tails.judges import HiddenMode, OppositeModes
from tests.tuner.extensions.tails.estimation.closed_forms import Closed, corner, half_space
from tuner.extensions.tails.estimation.design_point import WholeSpace, find_design_point
from tuner.extensions.tails.estimation.estimate import estimate_tail
from tuner.extensions.tails.estimation.limit_function import Method, Status
from tuner.extensions.tails.estimation.planning import (
    Request,
    choose_method,
    expected_evaluations,
    pilot_evaluations,
    plan_tail,
)

WIDE = Request(relative_width=0.8)


def constant(value, dimension=3):
    return Closed(dimension, lambda u: [np.full(len(u), value)])


@pytest.mark.parametrize("method", [None, Method.CRUDE])
def test_the_interval_is_as_narrow_as_asked_and_near_the_truth(method):
    done = estimate_tail(half_space(3.2), 2, Request(relative_width=0.5, method=method))
    exact = norm.sf(3.2)
    assert done.status is Status.ESTIMATED
    assert done.high - done.low <= 0.5 * done.probability
    # A third of the width is 2.6 standard errors.
    assert abs(done.probability - exact) < 0.35 * exact
    assert done.method is (method or Method.SPLITTING)
    reached = norm.sf(3.2 * done.curve.levels)
    assert np.all(np.abs(done.curve.probability / reached - 1.0) < 0.4)


def test_each_named_mode_has_its_probability_share_and_design_point():
    limit = corner(4.0, 4.4)
    plan = plan_tail(limit, 3, WIDE)
    done = estimate_tail(limit, 3, WIDE, plan)
    first, second = done.modes
    names = [mode.name for mode in done.modes]
    for mode, distance in ((first, 4.0), (second, 4.4)):
        low, high = mode.interval
        assert low < norm.sf(distance) * 1.3 and high > norm.sf(distance) / 1.3
        number = names.index(mode.name)
        point = find_design_point(limit, number, WholeSpace(limit.dimension), plan.failures[number][0])
        assert point is not None and np.linalg.norm(point) == pytest.approx(distance, rel=0.01)
        assert np.argmax(point) == number
    assert first.share + second.share == pytest.approx(1.0, abs=0.02)
    assert first.share_interval.low < first.share < first.share_interval.high <= 1.0


def test_a_mode_hidden_behind_a_nearer_one_has_a_ladder_of_its_own():
    limit = HiddenMode(4.0)
    for seed in range(5):
        plan = plan_tail(limit, seed, WIDE)
        assert len(plan.sectors) == len(plan.ladders) == 2
        # The one ladder ends in the mode of distance 5, and finds a hundredth of the probability.
        assert limit.probability / 8.0 < plan.probability < 8.0 * limit.probability


def test_opposite_modes_that_do_not_hide_share_a_ladder():
    plan = plan_tail(OppositeModes(3.9, 4.1), 0, WIDE)
    assert not plan.sectors and len(plan.ladders) == 1


def test_a_resumed_estimate_is_the_same():
    limit, shown = half_space(3.5), []
    done = estimate_tail(limit, 5, WIDE, on_progress=shown.append)
    assert tuple(progress.replica for progress in shown) == done.replicas
    assert shown[-1].evaluations == done.evaluations and shown[-1].probability == done.probability
    plan, fresh = plan_tail(limit, 5, WIDE), []
    resumed = estimate_tail(limit, 5, WIDE, plan, done.replicas[:7], fresh.append)
    assert resumed.replicas == done.replicas
    assert (resumed.low, resumed.high, resumed.evaluations) == (done.low, done.high, done.evaluations)


@pytest.mark.parametrize(
    ("limit", "status", "low", "high"),
    [
        (constant(0.5, 0), Status.DETERMINISTIC, 0.0, 0.0),
        (constant(1.5, 0), Status.DETERMINISTIC, 1.0, 1.0),
        (constant(0.5), Status.UNREACHED, 0.0, 0.006),
        (constant(2.0), Status.CERTAIN, 0.999, 1.0),
        # A limit beyond the largest value of the metric: reaching that is the bound.
        (Closed(3, lambda u: [np.minimum(u[:, 0] / 5.0, 0.8)]), Status.UNREACHED, 0.0, 1e-4),
        # An event of 0 or 1 gives no way up.
        (Closed(3, lambda u: [np.where(u[:, 0] > 4.0, 1.0, 0.0)]), Status.UNREACHED, 0.0, 0.006),
        (half_space(9.0), Status.BELOW, 0.0, 1e-6),
    ],
)
def test_ends_without_an_estimate_bound_the_probability(limit, status, low, high):
    done = estimate_tail(limit, 2, Request())
    assert done.status is status
    assert done.low >= low and done.high <= high
    assert done.probability in (0.0, 1.0)


@pytest.mark.parametrize("below", [0.0, -np.inf])
def test_a_rare_mode_does_not_bound_one_without_a_ladder(below):
    """A mode without any demand below its limit, minus infinity, has no ladder at all."""
    limit = Closed(3, lambda u: [u[:, 0] / 9.0, np.where(u[:, 1] > 3.5, 1.0, below)], ("rare", "sudden"))
    plan = plan_tail(limit, 2, Request())
    assert len(plan.ladders) == (1 if below < 0.0 else 2)
    done = estimate_tail(limit, 2, Request(), plan)
    assert done.status is Status.UNREACHED
    assert done.high > norm.sf(3.5)


def test_an_impossible_mode_takes_nothing_from_the_others():
    limit = Closed(3, lambda u: [u[:, 0] / 3.5, 0.0 * u[:, 1]], ("may", "never"))
    may, never = estimate_tail(limit, 2, WIDE).modes
    assert may.share == 1.0
    assert never.probability == 0.0 and never.interval.low == 0.0 < never.interval.high < 0.01


def test_discrete_demands_have_levels():
    done = estimate_tail(Closed(3, lambda u: [np.floor(u[:, 0]) / 4.0]), 2, WIDE)
    assert done.status is Status.ESTIMATED
    assert done.low < norm.sf(4.0) < done.high


def test_what_has_no_value_fails():
    done = estimate_tail(Closed(3, lambda u: [np.where(u[:, 0] > 3.5, np.nan, u[:, 0] / 9.0)]), 2, WIDE)
    assert done.low < norm.sf(3.5) < done.high


@pytest.mark.parametrize("dimension", [5, 64])
@pytest.mark.parametrize("most", [1, 10_000, 40_000])
def test_no_more_rows_are_evaluated_than_allowed(most, dimension):
    rows = []
    limit = Closed(dimension, lambda u: [(rows.append(len(u)) or u[:, 0]) / 4.5])
    done = estimate_tail(limit, 2, Request(relative_width=0.2, most_evaluations=most))
    assert done.status is Status.WIDE and done.evaluations == sum(rows) <= most
    assert done.low <= norm.sf(4.5) <= done.high


def test_zero_of_a_thousand_is_bounded_on_one_side():
    done = estimate_tail(half_space(6.0), 2, Request(method=Method.CRUDE, most_evaluations=1000))
    assert (done.probability, done.low) == (0.0, 0.0)
    assert done.high == pytest.approx(1.0 - 0.05 ** (1.0 / 1000.0))


@pytest.mark.parametrize("limit", [half_space(5.2, 64), HiddenMode(4.0), OppositeModes(4.0, 4.5)])
def test_a_pilot_takes_no_more_rows_than_its_bound(limit):
    bound = pilot_evaluations(limit, WIDE.smallest)
    assert bound / 5.0 < plan_tail(limit, 1, WIDE).evaluations <= bound


def test_the_method_that_costs_less_is_chosen():
    for probability in (0.3, 0.02, 0.004, 1e-4, 1e-6):
        costs = {method: expected_evaluations(probability, 0.5, method) for method in (Method.CRUDE, Method.SPLITTING)}
        assert costs[choose_method(probability)] <= 1.2 * min(costs.values())


def test_replicas_that_are_all_0_are_bounded_by_the_independent_rows():
    """The ladders reached the event in the pilot, and no replica met it: 0 of n bounds it by 1 - 0.05^(1/n)."""
    limit = half_space(3.5)
    plan = plan_tail(limit, 5, WIDE)
    assert any(ladder.target == 1.0 for ladder in plan.ladders)
    never = [
        replica._replace(probability=0.0, ladders=tuple(0.0 for _ in replica.ladders))
        for replica in estimate_tail(limit, 5, WIDE, plan).replicas
    ]
    done = estimate_tail(limit, 5, WIDE, plan, never)
    assert done.probability == done.low == 0.0
    assert done.high == pytest.approx(1.0 - 0.05 ** (1.0 / plan.independent), rel=1e-9)
