"""Bounds of quantiles beside printed sample sizes, the binomial and beta distributions, and drawn values."""

import numpy as np
import pytest
from scipy.stats import beta, binom

from objectives.risk import bound_rank, flights_to_bound


@pytest.mark.parametrize(
    ("confidence", "level", "flights"),
    [(0.95, 0.95, 59), (0.95, 0.99, 299), (0.9, 0.997, 767), (0.95, 0.9, 29), (0.99, 0.99, 459), (0.5, 0.5, 1)],
)
def test_flights_are_those_of_the_tables(confidence, level, flights):
    assert flights_to_bound(level, confidence) == flights
    assert bound_rank(flights, level, confidence) == 1
    assert bound_rank(flights - 1, level, confidence) is None


def test_the_second_and_third_largest_take_the_flights_of_the_tables():
    # One-sided 95/95 of higher order.
    for rank, flights in ((2, 93), (3, 124), (4, 153)):
        assert bound_rank(flights, 0.95) == rank
        assert bound_rank(flights - 1, 0.95) == rank - 1


@pytest.mark.parametrize("count", [59, 500, 20_000])
@pytest.mark.parametrize("level", [0.5, 0.95, 0.99])
def test_the_rank_is_that_of_the_binomial_and_of_the_beta_distribution(count, level):
    rank = bound_rank(count, level)
    if rank is None:
        assert level**count > 0.05
        return
    confident = [binom.sf(k - 1, count, 1.0 - level) for k in (rank, rank + 1)]
    assert confident[0] >= 0.95 > confident[1]
    # The share below the k-th largest is distributed as beta(n - k + 1, k).
    assert beta.sf(level, count - rank + 1, rank) == pytest.approx(confident[0], rel=1e-9)


def test_drawn_values_stay_below_as_often_as_promised():
    rng = np.random.default_rng(1)
    count, level, repeats = 153, 0.95, 20_000
    uniform = rng.random((repeats, count))
    bound = np.partition(uniform, -4, axis=1)[:, -4]
    # 4 standard errors of a share of 0.95.
    assert np.mean(bound >= level) == pytest.approx(
        beta.sf(level, count - 3, 4), abs=4 * (0.05 * 0.95 / repeats) ** 0.5
    )
