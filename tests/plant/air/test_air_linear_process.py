"""Exact sampling of linear processes, against closed forms, Van Loan's block exponential and statistics."""

import numpy as np
import pytest
from scipy.linalg import expm

from plant.air.dryden import transverse
from plant.air.linear_process import LinearProcess, discretize, gauss_markov, sample, stationary_covariance

STEPS = (1e-3, 1e-2, 1.0, 10.0)
# A gust of tau 3 s with a rate lag of 0.05 s: dt = 10 s is 200 of the short lag, dt = 1 ms is 1/3000 of the long one.
CASCADE = transverse(3.0, 0.05, 0.2)


def two_lags(tau):
    """The transverse gust without its rate, typed as a second-order system of its own."""
    root = np.sqrt(tau)
    a = np.array([[-1.0 / tau, 0.0], [1.0 / tau, -1.0 / tau]])
    return LinearProcess(a, np.array([1.0 / tau, 0.0]), np.array([[np.sqrt(3.0) * root, (1.0 - np.sqrt(3.0)) * root]]))


@pytest.mark.parametrize("dt", STEPS)
@pytest.mark.parametrize(
    "process", [gauss_markov(0.7), two_lags(2.0), CASCADE], ids=["one lag", "two lags", "three lags"]
)
def test_stationary_covariance_is_kept_by_a_step(process, dt):
    sampled, covariance = discretize(process, dt), stationary_covariance(process)
    kept = sampled.transition @ covariance @ sampled.transition.T + sampled.noise @ sampled.noise.T
    scale = np.sqrt(np.outer(np.diag(covariance), np.diag(covariance)))
    assert np.abs((kept - covariance) / scale).max() < 1e-12
    assert np.abs((sampled.start @ sampled.start.T - covariance) / scale).max() < 1e-12


@pytest.mark.parametrize("alpha", [1e-3, 0.1, 1.0, 8.0])
def test_two_equal_lags_have_the_closed_form_noise(alpha):
    tau = 2.5
    e, sampled = np.exp(-2.0 * alpha), discretize(two_lags(tau), alpha * tau)
    off = 0.25 - e * (alpha / 2.0 + 0.25)
    expected = np.array([[(1.0 - e) / 2.0, off], [off, 0.25 - e * (alpha**2 / 2.0 + alpha / 2.0 + 0.25)]]) / tau
    # The closed form itself cancels: its smallest entry is alpha^3 / 6 out of terms of 1/4, so 1e-16 absolute.
    np.testing.assert_allclose(sampled.noise @ sampled.noise.T, expected, rtol=1e-12, atol=2e-16)
    np.testing.assert_allclose(sampled.transition, np.exp(-alpha) * np.array([[1.0, 0.0], [alpha, 1.0]]), rtol=1e-12)


@pytest.mark.parametrize("dt", [1e-3, 1e-2, 0.1])
def test_noise_agrees_with_van_loan(dt):
    a, bb = CASCADE.a, np.outer(CASCADE.b, CASCADE.b)
    block = expm(np.block([[-a, bb], [np.zeros_like(a), a.T]]) * dt)
    van_loan, noise = block[3:, 3:].T @ block[:3, 3:], discretize(CASCADE, dt).noise
    # At 0.1 s the block holds exp(+2), at 1 ms its entries span 1e-3 to 1e-12 with errors near 1e-16 of the largest.
    np.testing.assert_allclose(noise @ noise.T, van_loan, rtol=1e-9)


def test_noise_of_a_small_step_has_the_series_of_a_double_integrator():
    # b dW, then its integral: Q -> b^2 [[dt, k dt^2 / 2], [., k^2 dt^3 / 3]]; next terms: dt / tau = 1e-7 of these.
    dt, factor = 1e-6, discretize(two_lags(10.0), 1e-6).noise
    expected = 0.1 * np.array([[np.sqrt(dt), 0.0], [0.1 * np.sqrt(dt) * dt / 2.0, 0.1 * np.sqrt(dt**3 / 12.0)]])
    np.testing.assert_allclose(factor, expected, rtol=1e-6)


def test_noise_factor_of_one_step_composes_into_two():
    one, two = discretize(CASCADE, 0.37), discretize(CASCADE, 0.74)
    twice = one.transition @ one.noise @ one.noise.T @ one.transition.T + one.noise @ one.noise.T
    np.testing.assert_allclose(two.noise @ two.noise.T, twice, rtol=1e-11)


def test_sampling_is_the_matrix_recursion():
    sampled = discretize(CASCADE, 0.02)
    normals = np.random.default_rng(5).standard_normal((300, 3))
    x = sampled.start @ normals[0]
    expected = [sampled.output @ x]
    for row in normals[1:]:
        x = sampled.transition @ x + sampled.noise @ row
        expected.append(sampled.output @ x)
    np.testing.assert_allclose(sample(sampled, normals), expected, rtol=1e-10, atol=1e-12)


def test_first_rows_and_first_states_do_not_depend_on_what_follows():
    sampled = discretize(CASCADE, 0.02)
    normals = np.random.default_rng(5).standard_normal((1001, 3))
    whole = sample(sampled, normals)
    for rows in (1, 2, 3, 8, 17, 1000):
        assert np.array_equal(sample(sampled, normals[:rows]), whole[:rows])
    assert np.array_equal(sample(sampled.leading(2, 1), normals[:, :2]), whole[:, :1])


def test_a_cut_that_drops_a_needed_state_is_our_mistake():
    with pytest.raises(AssertionError, match="reads a dropped state"):
        discretize(CASCADE, 0.02).leading(2, 2)


def test_the_start_is_stationary():
    sampled = discretize(CASCADE, 0.02)
    generator = np.random.default_rng(11)
    first = np.array([sample(sampled, generator.standard_normal((1, 3)))[0] for _ in range(4000)])
    variance = np.diag(CASCADE.c @ stationary_covariance(CASCADE) @ CASCADE.c.T)
    # The sample variance of 4000 normals has a relative standard deviation of sqrt(2 / 4000) = 2.2 %; five of them.
    np.testing.assert_allclose(first.var(axis=0), variance, rtol=0.112)
