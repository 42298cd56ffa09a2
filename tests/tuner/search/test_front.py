"""Fronts thinned by what points add to them."""

from itertools import combinations

import numpy as np
import pytest

from tuner.search.front import hypervolume, knee, non_dominated, select_subset

ONE = np.ones(2)


def dented(count):
    """A front (count, 2) whose points crowd at one end."""
    angle = np.linspace(0.0, np.pi / 2.0, count) ** 2 / (np.pi / 2.0)
    return 1.0 - 0.9 * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def test_a_thinned_front_keeps_more_than_one_spread_evenly():
    front = dented(60)
    spread = np.linspace(0, 59, 6).round().astype(int)
    for ends in (True, False):
        picked = select_subset(front, ONE, 6, ends)
        assert len(set(picked.tolist())) == 6
        assert hypervolume(front[picked], ONE) > hypervolume(front[spread], ONE)


@pytest.mark.parametrize("objectives", [2, 3])
def test_each_point_is_the_best_next_one(objectives):
    """Looked for among all, without the bounds that spare most of them."""
    draw = np.random.default_rng(objectives)
    front = np.abs(draw.standard_normal((30, objectives)))
    front /= np.linalg.norm(front, axis=1, keepdims=True)
    base, picked = np.ones(objectives), []
    for _ in range(7):
        left = [row for row in range(30) if row not in picked]
        picked.append(max(left, key=lambda row: hypervolume(front[[*picked, row]], base)))
    assert select_subset(front, base, 7, ends=False).tolist() == picked


def test_one_after_the_other_keeps_at_least_63_percent_of_the_best_subset():
    """G. L. Nemhauser, L. A. Wolsey, M. L. Fisher, Mathematical Programming 14:265-294, 1978; here it is far above."""
    front = dented(14)
    best = max(hypervolume(front[list(rows)], ONE) for rows in combinations(range(14), 4))
    assert hypervolume(front[select_subset(front, ONE, 4, ends=False)], ONE) > 0.97 * best


def test_the_best_of_each_objective_stay():
    front = dented(60)
    assert {0, 59} <= set(select_subset(front, front.max(axis=0), 5).tolist())
    assert set(select_subset(front, ONE, 1).tolist()) <= {0, 59}


def test_a_short_front_stays_as_it_is():
    assert select_subset(dented(5), ONE, 5).tolist() == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("objectives", [1, 2, 3])
@pytest.mark.parametrize("count", [1, 32, 33, 200])
def test_what_nothing_dominates_is_left_and_equal_points_stay(count, objectives):
    values = np.random.default_rng(count).integers(0, 6, size=(count, objectives)).astype(float)
    values[0] = np.inf
    assert non_dominated(values).tolist() == left_by_pairs(values)


@pytest.mark.parametrize("infinite", [np.inf, -np.inf])
@pytest.mark.parametrize("objectives", [2, 3, 4, 6])
def test_infinite_values_are_compared_as_others_are(objectives, infinite):
    # As they are, the library names wrong rows of 3, and with values below all others it ends the process.
    draw = np.random.default_rng(objectives)
    for _ in range(50):
        values = draw.integers(0, 5, size=(40, objectives)).astype(float)
        values[draw.random(values.shape) < 0.1] = infinite
        assert non_dominated(values).tolist() == left_by_pairs(values)


def left_by_pairs(values) -> list[bool]:
    """Mask of the rows that no other row dominates: each pair is compared."""
    return [not any(all(other <= one) and any(other < one) for other in values) for one in values]


def test_the_knee_of_a_wide_front_is_seen_on_its_own_scale():
    # An objective over three decades, the other over a factor of 4: on the natural scale all but the ends are one corner.
    wide = np.array([[1.0, 1000.0], [1.1, 100.0], [1.3, 10.0], [2.6, 1.5], [4.0, 1.0]])
    assert knee(wide) == 2
    assert knee(wide * [3.0, 0.2]) == 2
    # Negative values and zeros have no logarithm: the natural scale counts.
    assert knee(np.array([[0.0, 9.0], [1.0, 1.0], [100.0, 0.0]])) == 1


def test_a_front_that_is_bent_outwards_on_its_logarithms_has_its_knee_on_the_natural_scale():
    error = np.geomspace(1.0, 100.0, 9)
    outward = np.stack([error, np.exp(-np.square(np.log(error)) / 4.0)], axis=1)
    assert 0 < knee(outward) < 8


@pytest.mark.parametrize("noise", [0.0, 0.01, 0.05])
def test_a_few_points_more_or_less_move_the_knee_by_a_factor_of_10_at_most(noise):
    """One of a power law on logarithms rests on noise alone: one point beyond an end moved it by a factor of 4,000."""
    draw = np.random.default_rng(43)
    for _ in range(300):
        error = np.exp(draw.uniform(0.0, np.log(draw.uniform(3.0, 1000.0)), 30))
        front = np.column_stack([error, error ** -draw.uniform(0.5, 2.0)]) * np.exp(draw.normal(0.0, noise, (30, 2)))
        front = front[non_dominated(front)]
        point = front[knee(front)]
        beyond = [front[:, 0].max() * draw.uniform(1.0, 2.0), front[:, 1].min() * 0.9]
        fewer = front[draw.permutation(len(front))[3:]]
        for changed in (np.vstack([front, beyond]), fewer):
            moved = changed[knee(changed)] / point
            assert np.all((moved > 0.1) & (moved < 10.0))
