"""Total violations, scaled objectives, reference directions and tournaments, by hand and by counting."""

from math import comb

import numpy as np
import pytest

from tuner.search.constraint_ranking import TotalViolation, feasibility_order, power_of_two
from tuner.search.differential_evolution import three_others
from tuner.search.nsga3 import less_violating, reference_directions
from tuner.search.scaling import Scaling


@pytest.mark.parametrize("value", [1e-300, 0.25, 0.3, 1.0, 7.9, 1e300])
def test_power_of_two(value):
    found = power_of_two(value)
    assert found <= value < 2.0 * found
    assert np.frexp(found)[0] == 0.5


def test_each_constraint_counts_in_units_of_its_first_median():
    total = TotalViolation(3)
    # Medians of what is broken: 4 of (2, 4, 8), 0.5 of itself; the third is not broken so far.
    first = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [4.0, 0.5, 0.0], [8.0, 0.0, 0.0]])
    assert total.of(first).tolist() == [0.0, 0.5, 2.0, 2.0]
    # The units stay; the third gets its own, 1024 below 1500, when it is broken first.
    assert total.of(np.array([[0.0, 64.0, 0.0], [1.0, 0.0, 1500.0]])).tolist() == [128.0, 0.25 + 1500.0 / 1024.0]


def test_a_kept_constraint_does_not_make_up_for_a_broken_one():
    assert TotalViolation(2).of(np.array([[-5.0, 1.0], [-5.0, -1.0]])).tolist() == [1.0, 0.0]
    assert TotalViolation(0).of(np.empty((3, 0))).tolist() == [0.0, 0.0, 0.0]


def test_one_broken_constraint_keeps_its_order():
    broken = np.random.default_rng(1).uniform(0.0, 1e6, 500)
    assert np.array_equal(np.argsort(TotalViolation(1).of(broken[:, None])), np.argsort(broken))


def test_best_first_is_feasible_first_then_less_broken_then_better():
    values, totals = np.array([5.0, 1.0, 4.0, 0.0, 4.0, -1.0]), np.array([0.0, 2.0, 0.0, 1.0, 0.0, 2.0])
    assert feasibility_order(values, totals).tolist() == [2, 4, 0, 3, 5, 1]


def test_scaling_waits_for_a_feasible_candidate_and_keeps_to_it():
    scaling, values = Scaling(), np.array([[1e15, 3.0], [10.0, 3.0], [12.0, 3.0], [50.0, 3.0]])
    assert np.all(scaling.of(values, np.zeros(4, dtype=bool)) == 0.0)
    feasible = np.array([False, True, True, True])
    # The smallest is 10; of three the quarter is the smallest too, the half is 2 above. A constant objective has unit 1.
    assert scaling.of(values, feasible).tolist() == [[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [20.0, 0.0]]
    assert scaling.of(np.array([[8.0, 4.0]]), np.array([True])).tolist() == [[-1.0, 1.0]]


def test_three_others_differ_and_are_drawn_alike():
    draw, n, times = np.random.default_rng(1), 8, 3000
    rows = np.stack([three_others(n, draw) for _ in range(times)], axis=0)
    with_own = np.concatenate([rows, np.tile(np.arange(n)[None, :, None], (times, 1, 1))], axis=2)
    assert all(len(set(four)) == 4 for four in with_own.reshape(-1, 4).tolist())
    # Each place holds each of the seven others equally often, within five binomial standard deviations.
    counts = np.stack([np.sum(rows == other, axis=0) for other in range(n)], axis=0)
    expected = np.where(np.eye(n, dtype=bool)[:, :, None], 0.0, times / 7)
    assert np.all(np.abs(counts - expected) <= 5 * (times / 7 * 6 / 7) ** 0.5)
    assert np.all(counts[np.eye(n, dtype=bool)] == 0)


@pytest.mark.parametrize("objectives", [2, 3, 5, 8])
@pytest.mark.parametrize("population", [8, 26, 48, 100])
def test_reference_directions_are_as_many_as_fit(objectives, population):
    directions = reference_directions(objectives, population)
    assert len(directions) <= population
    assert np.all(directions >= 0.0)
    np.testing.assert_allclose(directions.sum(axis=1), 1.0, atol=1e-12)
    counts = [comb(objectives + divisions - 1, divisions) for divisions in range(1, population)]
    assert len(directions) == max(count for count in counts if count <= population)


def test_tournament_prefers_less_violation_and_else_either():
    class Population:
        def get(self, _):
            return np.array([[0.0], [3.0], [1.0], [0.0], [3.0]])

    draw = np.random.default_rng(1)
    pairs = np.tile([[0, 1], [1, 2], [0, 3], [1, 4]], (400, 1))
    won = less_violating(Population(), pairs, random_state=draw)
    assert won.shape == (1600, 1)
    winners = won[:, 0].reshape(400, 4)
    assert set(winners[:, 0]) == {0} and set(winners[:, 1]) == {2}
    # Half of 400 fair ties, within five standard deviations of 10.
    assert abs(np.sum(winners[:, 2] == 0) - 200) < 50 and abs(np.sum(winners[:, 3] == 1) - 200) < 50
