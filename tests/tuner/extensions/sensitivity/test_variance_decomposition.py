"""Gains against scenarios: closed forms, an independent least-squares fit, components recovered, relabelling."""

import numpy as np
import pytest

from plant.seeds import generator
from tuner.extensions.sensitivity.variance import two_way_anova


def drawn(g, s, deviations, index=0):
    """A table of random effects with standard deviations of gains, scenario and interaction."""
    draw = generator(3, "test/two-way", index)
    rows, columns, rest = draw.normal(size=(g, 1)), draw.normal(size=(1, s)), draw.normal(size=(g, s))
    return deviations[0] * rows + deviations[1] * columns + deviations[2] * rest


def test_an_additive_table_has_its_closed_form():
    rows, columns = np.array([1.0, 2.0, 6.0]), np.array([0.0, 4.0])
    found = two_way_anova(rows[:, None] + columns)
    # sum (r - 3)^2 = 14 in two columns; sum (c - 2)^2 = 8 in three rows.
    assert found.sums == pytest.approx((28.0, 24.0, 0.0), abs=1e-12)
    assert found.of_squares == pytest.approx((28 / 52, 24 / 52, 0.0), abs=1e-12)
    # Variances of the effects: 14/2 = 7 and 8/1 = 8.
    assert found.of_components == pytest.approx((7 / 15, 8 / 15, 0.0), abs=1e-12)
    assert found.of_components.turbulence == pytest.approx(8 / 15)


def test_sums_of_squares_are_those_of_nested_least_squares_fits():
    scores = drawn(7, 5, (1.0, 2.0, 0.5))
    rows, columns = (np.repeat(np.eye(7), 5, axis=0), np.tile(np.eye(5), (7, 1)))
    flat = scores.ravel()

    def left(*parts):
        design = np.concatenate([np.ones((35, 1)), *parts], axis=1)
        return np.sum((flat - design @ np.linalg.lstsq(design, flat, rcond=None)[0]) ** 2, axis=0)

    expected = (left() - left(rows), left() - left(columns), left(rows, columns))
    assert two_way_anova(scores).sums == pytest.approx(expected, rel=1e-10)
    assert sum(two_way_anova(scores).sums) == pytest.approx(left(), rel=1e-12)


def test_components_are_recovered_whatever_the_number_of_scenarios():
    # A variance from 400 effects has a relative standard error of sqrt(2/399) = 7 %; from 40, 22 %.
    truth = np.array([1.0, 4.0, 0.25]) / 5.25
    for g, s, tolerance in ((400, 400, 0.06), (400, 40, 0.15)):
        found = [two_way_anova(drawn(g, s, (1.0, 2.0, 0.5), i)).of_components for i in range(5)]
        assert np.allclose(np.mean(found, axis=0), truth, atol=tolerance), (g, s)
    few = [two_way_anova(drawn(400, 2, (0.0, 0.0, 1.0), i)) for i in range(20)]
    # With two scenarios half of a table of nothing but interaction looks like gains; its components do not.
    assert np.mean([entry.of_squares.gains for entry in few], axis=0) == pytest.approx(0.5, abs=0.05)
    assert np.mean([entry.of_components.interaction for entry in few], axis=0) > 0.95


def test_relabelling_changes_nothing():
    scores = drawn(9, 6, (1.0, 1.0, 1.0))
    draw = generator(3, "test/relabel", 0)
    other = two_way_anova(scores[draw.permutation(9)][:, draw.permutation(6)])
    assert other.sums == pytest.approx(two_way_anova(scores).sums, rel=1e-12)
    turned = two_way_anova(scores.T).sums
    assert (turned[1], turned[0], turned[2]) == pytest.approx(two_way_anova(scores).sums, rel=1e-12)


def test_units_and_levels_change_no_share():
    scores = drawn(6, 5, (1.0, 2.0, 0.5))
    assert two_way_anova(1e-3 * scores + 7.0).of_components == pytest.approx(
        two_way_anova(scores).of_components, rel=1e-9
    )


def test_a_constant_table_has_no_shares():
    found = two_way_anova(np.full((3, 4), 2.5))
    assert found.sums == (0.0, 0.0, 0.0)
    assert found.of_squares == found.of_components == (0.0, 0.0, 0.0)
