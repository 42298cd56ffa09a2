"""The misfit: symmetric in ratios, zero where all is met, kinds counted alike; and where a published value stands."""

from math import log

import numpy as np
import pytest
from scipy import stats

from tuner.experiments.contest.judging import is_inside, percentile_of
from tuner.experiments.inference.misfit import (
    log_ratio,
    misfits,
    overall,
    tolerance,
    weights,
)

PUBLISHED = np.array([0.1, 0.2, 5.0, 8.0, 10.0])
KINDS = np.array([0, 0, 1, 1, 1])


def test_no_misfit_where_all_is_met():
    assert misfits(PUBLISHED[None], PUBLISHED, KINDS).tolist() == [[0.0, 0.0]]


def test_twice_as_much_is_as_bad_as_half_as_much_whatever_the_unit():
    rows = PUBLISHED * np.array([2.0, 0.5])[:, None]
    assert misfits(rows, PUBLISHED, KINDS) == pytest.approx(np.full((2, 2), log(2.0)))
    assert misfits(1e3 * rows, 1e3 * PUBLISHED, KINDS) == pytest.approx(misfits(rows, PUBLISHED, KINDS))


def test_a_kind_sees_its_own_cells_only():
    row = PUBLISHED.copy()
    row[3] *= 4.0
    peaks, times = misfits(row[None], PUBLISHED, KINDS)[0]
    assert peaks == 0.0
    assert times == pytest.approx(log(4.0) / 3.0**0.5)


def test_kinds_count_alike_however_many_cells_they_have():
    rows = np.stack([PUBLISHED * np.where(KINDS == kind, 3.0, 1.0) for kind in (0, 1)])
    first, second = overall(misfits(rows, PUBLISHED, KINDS))
    assert first == pytest.approx(second)
    assert weights(KINDS).sum() == pytest.approx(1.0)
    odd = PUBLISHED * np.array([1.3, 0.4, 2.0, 0.9, 7.0])
    total = overall(misfits(odd[None], PUBLISHED, KINDS))[0]
    assert total**2 == pytest.approx(np.sum(weights(KINDS) * log_ratio(odd, PUBLISHED) ** 2))


def test_a_value_of_zero_costs_a_finite_ratio():
    assert log_ratio(np.zeros(5), PUBLISHED) == pytest.approx(-log(50.0))


def test_the_tolerance_of_a_lognormal_is_its_sigma():
    draw = np.random.default_rng(4)
    n, sigma = 20_000, np.array([0.1, 0.3, 1.0])
    scores = np.exp(sigma[:, None] * draw.standard_normal((3, n)))
    # A quantile at p has the variance p (1 - p) / (n f^2); two of them, halved, with correlation below 1.
    z = stats.norm.ppf(0.84)
    error = np.sqrt(0.16 * 0.84 / n) / stats.norm.pdf(z) * sigma
    assert np.all(np.abs(tolerance(scores, np.ones(3)) - z * sigma) < 4.0 * error)


def test_percentiles_of_draws_of_the_same_kind_are_uniform():
    draw = np.random.default_rng(5)
    scores, published = draw.gamma(3.0, size=(4000, 1, 400)), draw.gamma(3.0, size=(4000, 1))
    settings = np.array([percentile_of(p, s)[0] for s, p in zip(scores, published, strict=True)])
    assert stats.kstest(settings / 100.0, "uniform").pvalue > 1e-3
    assert abs(is_inside(settings).mean() - 0.95) < 4.0 * np.sqrt(0.95 * 0.05 / 4000) + 1.0 / 400


def test_ties_count_half_and_the_outermost_are_outside():
    scores = np.repeat(np.arange(1.0, 101.0)[None], 4, axis=0)
    assert percentile_of(np.array([0.0, 1.0, 50.5, 200.0]), scores).tolist() == [0.0, 0.5, 50.0, 100.0]
    assert is_inside(np.array([0.0, 2.4, 2.5, 50.0, 97.5, 97.6])).tolist() == [False, False, True, True, True, False]


def test_percentiles_take_many_settings_at_once():
    scores = np.random.default_rng(6).normal(size=(3, 5, 40))
    published = np.zeros(5)
    together = percentile_of(published, scores)
    assert np.array_equal(together, np.stack([percentile_of(published, one) for one in scores]))
