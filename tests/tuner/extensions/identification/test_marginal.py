"""Marginal posterior of a number that acts linearly, against draws of the prior weighted by the likelihood."""

import numpy as np
import pytest

from tuner.extensions.vehicle_fit.marginal import marginal_moments, with_moments

CENTER, PRIOR_STD = np.log(0.4), 1.0


def mode_of(measured, noise):
    """Return mode and variance of the normal approximation of the posterior of a logarithm."""
    x = np.linspace(CENTER - 8.0, CENTER + 8.0, 400001)
    cost = ((np.exp(x) - measured) / noise) ** 2 + ((x - CENTER) / PRIOR_STD) ** 2
    mode = float(x[np.argmin(cost)])
    return mode, 1.0 / ((np.exp(mode) / noise) ** 2 + PRIOR_STD**-2)


@pytest.mark.parametrize(("measured", "noise"), [(1.4, 0.5), (0.4, 0.3), (0.1, 0.4), (3.0, 0.05)])
def test_moments_are_those_of_weighted_draws(measured, noise):
    draws = CENTER + PRIOR_STD * np.random.default_rng(1).normal(size=2_000_000)
    weights = np.exp(-0.5 * ((np.exp(draws) - measured) / noise) ** 2)
    mean = np.average(draws, weights=weights)
    variance = np.average((draws - mean) ** 2, weights=weights)
    found = marginal_moments(*mode_of(measured, noise), CENTER, PRIOR_STD)
    assert found == pytest.approx((mean, variance), rel=0.02, abs=1e-3)


def test_a_large_estimate_of_little_data_is_less_certain_than_a_normal_approximation_says():
    mode, variance = mode_of(1.4, 0.5)
    mean, wider = marginal_moments(mode, variance, CENTER, PRIOR_STD)
    assert wider > 1.5 * variance and mean < mode


def test_without_data_it_is_the_prior():
    assert marginal_moments(CENTER, PRIOR_STD**2, CENTER, PRIOR_STD) == (CENTER, PRIOR_STD**2)


def test_other_numbers_follow_by_regression():
    covariance = np.array([[1.0, 0.5], [0.5, 2.0]])
    moved, spread = with_moments(np.zeros(2), covariance, 0, 2.0, 4.0)
    assert moved == pytest.approx([2.0, 1.0])
    assert spread == pytest.approx(np.array([[4.0, 2.0], [2.0, 2.75]]))
