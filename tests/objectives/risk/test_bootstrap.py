"""Bootstrap intervals: coverage, pairing, and independence of how the work is cut up."""

from math import sqrt

import numpy as np
import pytest
from scipy.stats import norm, t

from objectives.risk import Risk, bootstrap
from tests.objectives.risk.resampling import bootstrap_interval, paired_difference

MEAN = Risk("mean")
RISKS = [MEAN, Risk("quantile", 0.8), Risk("cvar", 0.8), Risk("worst")]


def rng(seed: int = 1) -> np.random.Generator:
    """Return a seeded generator."""
    return np.random.default_rng(seed)


@pytest.mark.parametrize("confidence", [0.8, 0.95])
def test_coverage_of_the_mean(confidence: float) -> None:
    experiments, n = 1000, 30
    interval = bootstrap_interval(rng(2).normal(3.0, 2.0, (experiments, n)), MEAN, rng(), 1000, confidence)
    share = np.mean((interval.low <= 3.0) & (interval.high >= 3.0), axis=0)
    # The percentile interval of a mean is mean +- z s sqrt((n-1)/n)/sqrt(n) up to O(1/n): a t probability covers.
    expected = 1.0 - 2.0 * t.sf(norm.ppf(0.5 + 0.5 * confidence) * sqrt((n - 1) / n), n - 1)
    # Four binomial standard deviations (0.03 at 95 %), and 0.01 for 1000 replicates and the O(1/n).
    tolerance = 4.0 * sqrt(expected * (1.0 - expected) / experiments) + 0.01
    assert share == pytest.approx(expected, abs=tolerance)


def test_width_of_the_mean_is_the_normal_one() -> None:
    n, replicates = 400, 4000
    values = rng(3).exponential(2.0, n)
    interval = bootstrap_interval(values, MEAN, rng(), replicates)
    half = 1.959964 * np.std(values, axis=0) / sqrt(n)
    # A 2.5 % quantile of R normal replicates has the standard error sqrt(p (1-p)/R)/phi(1.96) = 0.042 sigma, 2.2 % of
    # the half width; each end may be off by four of these, and by 3 % for the skewness 2/sqrt(400) of the replicates.
    assert interval.high - np.mean(values, axis=0) == pytest.approx(half, rel=0.12)
    assert np.mean(values, axis=0) - interval.low == pytest.approx(half, rel=0.12)


def test_interval_of_the_median_has_order_statistics_as_ends() -> None:
    # Every replicate of an exact sample quantile is a value of the sample; for the median of n = 101 the ends lie near
    # the ranks 51 -+ 1.96 sqrt(101)/2 = 41 and 61 (binomial interval), to within one or two of them.
    values = np.arange(1.0, 102.0)
    interval = bootstrap_interval(rng(4).permutation(values), Risk("quantile", 0.5), rng(), 4000)
    assert float(interval.low) == pytest.approx(41.0, abs=2.5)
    assert float(interval.high) == pytest.approx(61.0, abs=2.5)


def test_every_scenario_can_be_drawn_and_left_out() -> None:
    # A scenario is in a resample with probability 1 - (1 - 1/8)^8 = 0.66, so both ends are reached in 500 of them.
    interval = bootstrap_interval(np.eye(8), Risk("worst"), rng(), 500)
    np.testing.assert_array_equal(interval.low, 0.0)
    np.testing.assert_array_equal(interval.high, 1.0)


@pytest.mark.parametrize("risk", RISKS, ids=str)
def test_an_entry_does_not_depend_on_its_neighbours(risk: Risk) -> None:
    values = rng(5).normal(0.0, 1.0, (2, 3, 20))
    together = bootstrap_interval(values, risk, rng(), 200)
    assert together.low.shape == together.high.shape == (2, 3)
    for index in np.ndindex(2, 3):
        alone = bootstrap_interval(values[index], risk, rng(), 200)
        assert (alone.low, alone.high) == (together.low[index], together.high[index])


@pytest.mark.parametrize("risk", RISKS, ids=str)
def test_small_blocks_give_the_same_bits(risk: Risk, monkeypatch: pytest.MonkeyPatch) -> None:
    values = rng(6).normal(0.0, 1.0, (7, 20))
    whole = bootstrap_interval(values, risk, rng(), 200), paired_difference(values, values**2, risk, rng(), 200)
    for block in (1, 130, 500):
        monkeypatch.setattr(bootstrap, "BLOCK", block)
        cut = bootstrap_interval(values, risk, rng(), 200), paired_difference(values, values**2, risk, rng(), 200)
        for one, other in zip(whole, cut, strict=True):
            for a, b in zip(one, other, strict=True):
                np.testing.assert_array_equal(a, b)


def test_seed_decides() -> None:
    values = rng(7).normal(0.0, 1.0, 30)
    assert bootstrap_interval(values, MEAN, rng(1)) == bootstrap_interval(values, MEAN, rng(1))
    assert bootstrap_interval(values, MEAN, rng(1)) != bootstrap_interval(values, MEAN, rng(2))


@pytest.mark.parametrize("risk", RISKS, ids=str)
def test_scenarios_are_paired(risk: Risk) -> None:
    # With the same scenarios in both, a candidate that is worse by 0.25 in each differs by 0.25 in every replicate.
    values = rng(8).normal(10.0, 3.0, (4, 25))
    found = paired_difference(values + 0.25, values, risk, rng(), 300)
    for part in found:
        np.testing.assert_allclose(part, np.full(4, 0.25), rtol=1e-9)


def test_difference_has_the_sign_of_the_first_minus_the_second() -> None:
    common = rng(9).normal(10.0, 3.0, 60)
    better, worse = common + rng(10).normal(0.0, 0.2, 60), common + 1.0 + rng(11).normal(0.0, 0.2, 60)
    found = paired_difference(better, worse, MEAN, rng())
    assert found.low < found.difference < found.high < 0.0
    # Independent of the spread 3 that both share: half width 1.96 * 0.2 sqrt(2)/sqrt(60) = 0.072, not 1.07.
    assert found.high - found.low < 0.3
    swapped = paired_difference(worse, better, MEAN, rng())
    np.testing.assert_allclose(
        [swapped.difference, swapped.low, swapped.high], [-found.difference, -found.high, -found.low], rtol=1e-9
    )


@pytest.mark.parametrize("risk", RISKS, ids=str)
def test_equal_scenarios_leave_no_doubt(risk: Risk) -> None:
    interval = bootstrap_interval(np.full((2, 9), 4.5), risk, rng(), 50)
    np.testing.assert_allclose(np.stack(interval, axis=0), 4.5, rtol=1e-12)
