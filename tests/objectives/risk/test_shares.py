"""Intervals of shares and of their differences hold what they promise, exactly: probabilities are summed, nothing is drawn."""

from itertools import product
from typing import Any

import numpy as np
import pytest
from scipy.stats import binom, binomtest, multinomial

from objectives.metrics import METRICS, parse
from objectives.problem import Constraint, Objective
from objectives.risk import (
    Risk,
    binary_difference,
    binary_interval,
    clopper_pearson,
    flights_to_show,
    interval_on,
    share_difference,
    upper_bound,
)
from tuner.documents.parts import ShareCount

RATES = (0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05)
FAILURE = Objective(parse("failure"), Risk("mean"))
UNUSED: Any = np.zeros((1, 1), dtype=int)


@pytest.mark.parametrize("n", [64, 256, 1024])
@pytest.mark.parametrize("rate", RATES)
def test_the_interval_of_a_share_never_covers_less_than_95_percent(rate, n):
    events = np.arange(n + 1)
    low, high = clopper_pearson(events, n)
    weights = binom.pmf(events, n, rate)
    assert weights[(low <= rate) & (rate <= high)].sum() >= 0.95
    # No interval without width hides in that: the exact tails are at most 2.5 % on either side.
    assert weights[rate > high].sum() <= 0.025 and weights[rate < low].sum() <= 0.025


@pytest.mark.parametrize("hits", [0, 1, 7, 63, 64])
def test_the_interval_of_a_share_is_scipy_s_exact_one(hits):
    expected = binomtest(hits, 64).proportion_ci(0.95, method="exact")
    assert clopper_pearson(hits, 64) == pytest.approx((expected.low, expected.high), abs=1e-12)


@pytest.mark.parametrize("n", [16, 64])
@pytest.mark.parametrize(
    ("first", "second"), [*product((0.0, 0.001, 0.01, 0.05), repeat=2), (0.2, 0.02), (0.3, 0.3), (0.02, 0.4)]
)
def test_the_interval_of_a_difference_never_covers_less_than_95_percent(first, second, n):
    """first, second: probability of an event of that one alone; what both have in common does not count."""
    pairs = np.array([(i, j) for i in range(n + 1) for j in range(n + 1 - i)])
    low, high = share_difference(pairs[:, 0], pairs[:, 1], n)
    counts = np.column_stack([pairs, n - pairs.sum(axis=1)])
    weights = multinomial.pmf(counts, n, [first, second, 1.0 - first - second])
    held = (low <= first - second + 1e-12) & (first - second - 1e-12 <= high)
    assert weights[held].sum() >= 0.95
    seen = (pairs[:, 0] - pairs[:, 1]) / n
    assert np.all((low <= seen) & (seen <= high)) and np.all(high > low)


def test_losses_of_one_alone_are_told_from_none_as_by_the_sign_test():
    # Ten flights lost by the second alone, of 256: p = 2 / 2^10 by McNemar's exact test.
    low, high = share_difference(0, 10, 256)
    assert low < -10 / 256 < high < 0.0
    # Four of four, p = 2 / 2^4 = 0.125, tell nothing.
    assert share_difference(0, 4, 256).high > 0.0


def test_no_loss_is_no_proof_of_none():
    values, resample = np.zeros((2, 256)), UNUSED
    low, high = FAILURE.interval(values, resample)
    # 1 - 0.025^(1/256); the percentile interval of a bootstrap is [0, 0].
    assert np.all(low == 0.0) and high == pytest.approx(1.0 - 0.025 ** (1 / 256))
    apart = FAILURE.difference(values[0], values[1], resample)
    assert apart.difference == 0.0 and apart.low < -0.01 and apart.high > 0.01
    assert ShareCount.of(values[0]).words == "0 of 256: at most 1.4 %"
    # One zero, one bound: that of the interval, of the difference and of the count.
    assert ShareCount.of(values[0]).upper == high[0] == apart.high == -apart.low
    assert upper_bound(0, 256) == pytest.approx(1.0 - 0.05 ** (1 / 256))
    assert ShareCount.of(np.eye(1, 256)[0]).words == "1 of 256"


@pytest.mark.parametrize(("limit", "flights"), [(0.01, 368), (0.05, 72), (0.5, 6)])
def test_flights_that_show_a_share_are_the_fewest_whose_upper_end_keeps_it(limit, flights):
    assert flights_to_show(limit) == flights
    assert clopper_pearson(0, flights).high <= limit < clopper_pearson(0, flights - 1).high


@pytest.mark.parametrize("risk", [Risk("cvar", 0.9), Risk("quantile", 0.9), Risk("worst")], ids=str)
@pytest.mark.parametrize("rate", [0.002, 0.05, 0.12])
def test_other_risks_of_a_share_are_covered_too(risk, rate):
    """The risk of 0 and 1 at a rate, from the definition on 100,000 values, which is no formula of the share."""
    n = 128
    truth = float(risk.apply(np.arange(100_000) < rate * 100_000))
    events = np.arange(n + 1)
    values = np.arange(n) < events[:, None]
    low, high = Objective(parse("failure"), risk).interval(values.astype(float), UNUSED)
    assert binom.pmf(events, n, rate)[(low <= truth + 1e-9) & (truth - 1e-9 <= high)].sum() >= 0.95


def test_an_interval_is_exact_by_the_metric_s_mark_and_not_by_its_values():
    saturation, values = Objective(parse("saturation"), Risk("mean")), np.repeat([0.0, 1.0], [60, 4])
    drawn = np.random.default_rng(1).integers(64, size=(400, 64))
    assert saturation.interval(values, drawn) == interval_on(values, Risk("mean"), drawn)
    assert [name for name, metric in METRICS.items() if metric.is_binary] == ["failure"]


@pytest.mark.parametrize(("most", "confidence", "alone"), [(0.0, 0.95, True), (0.01, 0.95, False), (0.01, 0.0, True)])
def test_a_share_of_zero_is_a_matter_of_the_flights_made(most, confidence, alone):
    assert Constraint(FAILURE, most, confidence=confidence).rests_on_value == alone
    worst = Constraint(Objective(parse("travel"), Risk("worst")), 1.0, confidence=confidence)
    assert worst.rests_on_value


def test_an_interval_of_a_metric_has_no_end_below_zero():
    # Eight values of which most are 0: the studentised end alone lies below 0.
    values = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.2, 1.0])
    drawn, risk = np.random.default_rng(3).integers(8, size=(400, 8)), Risk("mean")
    assert interval_on(values, risk, drawn).low < 0.0
    low, high = Objective(parse("itae.x"), risk).interval(values, drawn)
    assert low == 0.0 and high == interval_on(values, risk, drawn).high
    assert (
        Objective(parse("itae.x"), risk).interval(values - 1.0, drawn).low == interval_on(values - 1.0, risk, drawn).low
    )


def test_a_probability_has_the_intervals_of_the_share_that_stands_for_it():
    lost, others = (np.asarray(np.arange(200) < count, np.float64) for count in (7, 3))
    one, other = (Risk(name) for name in ("probability", "mean"))
    assert np.array_equal(binary_interval(lost, one), binary_interval(lost, other))
    assert np.array_equal(binary_difference(lost, others, one), binary_difference(lost, others, other))
