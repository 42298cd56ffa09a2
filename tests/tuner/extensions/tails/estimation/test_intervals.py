"""Intervals of replicas' means hold them as often as they say, on lognormal replicas of known mean."""

import numpy as np
import pytest
from scipy import stats

from tuner.extensions.tails.estimation.intervals import (
    FIRST,
    WIDENING,
    mean_interval,
    ratio_interval,
    replicas_needed,
    student_quantile,
    upper_end,
)

VARIATIONS = (0.3, 0.5, 0.7)


def lognormal(rng, variation, size):
    """Return numbers of mean 1."""
    spread = np.sqrt(np.log1p(variation**2))
    return np.exp(spread * rng.standard_normal(size) - 0.5 * spread**2)


@pytest.mark.parametrize("variation", VARIATIONS)
def test_the_two_stage_interval_holds_the_mean_in_93_to_97_percent(variation):
    rng, held, repeats = np.random.default_rng(11), 0, 4000
    for _ in range(repeats):
        values = lognormal(rng, variation, FIRST)
        count = replicas_needed(float(np.std(values, ddof=1) / np.mean(values)), 0.5, 0.95)
        values = np.concatenate([values, lognormal(rng, variation, count - FIRST)])
        low, high = mean_interval(values, 0.95)
        held += bool(low <= 1.0 <= high)
    # 4000 repeats have a standard error of 0.0035.
    assert 0.935 < held / repeats < 0.97


def test_columns_have_intervals_apart():
    values = lognormal(np.random.default_rng(1), 0.5, (20, 3))
    together = mean_interval(values, 0.95)
    for place in range(3):
        alone = mean_interval(values[:, place], 0.95)
        assert (together.low[place], together.high[place]) == pytest.approx((alone.low, alone.high))


def test_replicas_of_zero_have_no_width():
    assert mean_interval(np.zeros(5), 0.95) == (0.0, 0.0)


def test_a_constant_ratio_has_no_width():
    below = lognormal(np.random.default_rng(2), 0.5, 20)
    assert ratio_interval(0.25 * below, below, 0.95) == pytest.approx((0.25, 0.25))


def test_the_number_needed_gives_the_width():
    values = lognormal(np.random.default_rng(3), 0.5, FIRST)
    variation = float(np.std(values, ddof=1) / np.mean(values))
    count = replicas_needed(variation, 0.3, 0.95)
    repeated = np.resize(values, count)
    low, high = mean_interval(repeated, 0.95)
    assert (high - low) / np.mean(repeated) == pytest.approx(0.3, rel=0.1)
    assert count > FIRST == replicas_needed(0.01, 0.3, 0.95)


def test_the_one_sided_end_lies_within_the_two_sided_interval():
    values = lognormal(np.random.default_rng(4), 0.5, FIRST)
    assert np.mean(values) < upper_end(values, 0.95) < mean_interval(values, 0.95).high


@pytest.mark.parametrize(
    ("count", "degrees"), [(2, 1), (5, 4), (FIRST, FIRST - 1), (FIRST + 1, FIRST - 1), (2000, FIRST - 1)]
)
def test_the_quantile_has_the_degrees_of_freedom_of_the_first_replicas_alone(count, degrees):
    """C. Stein: the spread of the first replicas decides their number, so further ones add no degree of freedom."""
    assert student_quantile(0.95, count) == pytest.approx(WIDENING * stats.t.ppf(0.975, degrees), rel=1e-9)
