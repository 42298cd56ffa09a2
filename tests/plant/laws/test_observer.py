"""The sampled extended state observer: poles, steady errors, bounds."""

from math import exp

import numpy as np
import pytest

from plant.laws.observer import Observer, ObserverConstants, observe, observer_constants, placed
from tests.plant.harness import Array


def error_matrix(constants: ObserverConstants, h: float) -> Array:
    """Matrix of one period on the estimation error (z1, h z2, h^2 z3), linearised numerically; so scaled it is of order one."""
    scale = np.array([1.0, h, h * h])
    columns = [observe(Observer(*unit), constants, 0.0, 0.0, h) for unit in (np.eye(3) / scale).tolist()]
    return scale[:, None] * np.array(columns).T


@pytest.mark.parametrize("product", [0.01, 0.1, 0.5, 1.0, 1.99, 2.01, 5.0, 20.0])
@pytest.mark.parametrize("h", [0.001, 0.004, 0.1])
def test_all_poles_stand_at_the_sampled_bandwidth(product: float, h: float) -> None:
    # T7. A triple pole of one Jordan block: its eigenvalues scatter by eps^(1/3), but by Cayley and Hamilton (A -
    # beta)^3 = 0 to rounding.
    matrix = error_matrix(observer_constants(product / h, h), h)
    residue = np.linalg.matrix_power(matrix - exp(-product) * np.eye(3), 3)
    np.testing.assert_allclose(residue, 0.0, atol=1e-13)
    # Euler's form of the same observer is unstable from omega_o h = 2 on; this one has no limit.
    assert np.abs(np.linalg.eigvals(matrix)).max(axis=0) == pytest.approx(exp(-product), abs=1e-4)


def test_gains_tend_to_three_poles_in_one_place_and_not_to_the_printed_ones() -> None:
    # As h -> 0, l/h -> (b1, b2, b3) of (s + wo)^3 with error O(wo h) = 1e-4. T6: with b3 = 3 wo^3, as printed, the
    # roots would ring.
    omega_o, h = 10.0, 1e-5
    gains = np.array(observer_constants(omega_o, h)) / h / omega_o ** np.arange(1, 4)
    np.testing.assert_allclose(gains, [3.0, 3.0, 1.0], rtol=3e-4)
    printed = np.roots([1.0, *(gains * [1.0, 1.0, 3.0])])
    np.testing.assert_allclose(printed[np.argsort(printed.real, axis=0)][0], -2.2599, atol=1e-3)
    ringing = printed[np.abs(printed.imag) > 0.1]
    np.testing.assert_allclose([ringing.real.max(axis=0), ringing.imag.max(axis=0)], [-0.3700, 1.0911], atol=1e-3)


@pytest.mark.parametrize("h", [0.001, 0.1])
def test_poles_stand_where_they_are_placed(h: float) -> None:
    """One real pole anywhere and two more, real or conjugate: the polynomial of the error matrix has these roots."""
    rng = np.random.default_rng(3)
    for first, size, angle, second in rng.uniform([-0.9, 0.1, 0.0, -0.9], [0.99, 0.99, np.pi, 0.99], (40, 4)).tolist():
        for pair in (size * np.exp([1j * angle, -1j * angle]), np.array([second, size])):
            gaps = 1.0 - pair
            constants = placed(1.0 - first, float(gaps.sum(axis=0).real), float(gaps.prod(axis=0).real), h)
            wanted = np.poly([first, *pair]).real
            np.testing.assert_allclose(np.poly(error_matrix(constants, h)), wanted, rtol=0.0, atol=1e-13)


def test_three_poles_placed_in_one_point_are_the_bandwidth_form() -> None:
    for product in (1e-6, 0.01, 0.3, 2.0):
        gap = 1.0 - exp(-product)
        np.testing.assert_allclose(
            placed(gap, 2.0 * gap, gap * gap, 0.004), observer_constants(product / 0.004, 0.004), rtol=1e-9
        )


def follow(omega_o: float, h: float, jerks: Array) -> Array:
    """Run the observer on y'' = f with f' piecewise constant, which is integrated exactly; errors (K, 3)."""
    x, z, constants = np.zeros(3), Observer(0.0, 0.0, 0.0), observer_constants(omega_o, h)
    step = np.array([[1.0, h, h * h / 2.0], [0.0, 1.0, h], [0.0, 0.0, 1.0]])
    errors = []
    for jerk in jerks.tolist():
        x = step @ x + jerk * np.array([h**3 / 6.0, h * h / 2.0, h])
        z = observe(z, constants, float(x[0]), 0.0, h)
        errors.append(x - np.array(z))
    return np.array(errors)


def bounds(omega_o: float, most: float) -> Array:
    """T8: exact bounds of the estimation errors of the continuous observer for |f'| <= most."""
    return most * np.array([1.0 / omega_o**3, 3.0 / omega_o**2, 3.0 / omega_o])


@pytest.mark.parametrize("omega_o", [5.0, 20.0])
def test_a_ramp_of_disturbance_reaches_the_bounds(omega_o: float) -> None:
    # T8, equality. Sampling leaves O(wo h): at half the step, half the deviation. z3 lags by 3/wo of the slope.
    deviations = []
    for h in (0.001, 0.0005):
        errors = follow(omega_o, h, np.full(round(25.0 / omega_o / h), 4.0))
        deviations.append(np.abs(errors[-1] / bounds(omega_o, 4.0) - 1.0))
        assert (deviations[-1] < 1.6 * omega_o * h).all()
    np.testing.assert_allclose(deviations[1] / deviations[0], 0.5, atol=0.02)


def test_no_disturbance_of_bounded_slope_exceeds_the_bounds() -> None:
    # T8 with |f'| <= 1 switching at random; the sampled observer may exceed the continuous bound by a share of wo h.
    omega_o, h, rng = 10.0, 0.001, np.random.default_rng(8)
    for hold in (20, 100, 500):
        jerks = np.repeat(rng.choice([-1.0, 1.0], 8000 // hold), hold)
        errors = follow(omega_o, h, jerks)
        assert (np.abs(errors).max(axis=0) <= bounds(omega_o, 1.0) * (1.0 + 1.6 * omega_o * h)).all()


def test_a_known_input_leaves_no_error_and_a_constant_disturbance_is_found() -> None:
    # y'' = 2 + a with the acceleration a known: from the right state the estimate stays right; from z3 = 0 the error
    # dies as k^2 beta^k: after 400 periods of wo h = 0.1 that is 1.6e5 e^-40 = 7e-13 of it.
    h, constants, rng = 0.01, observer_constants(10.0, 0.01), np.random.default_rng(9)
    x = np.array([0.3, -0.2])
    exact, found = Observer(0.3, -0.2, 2.0), Observer(0.3, -0.2, 0.0)
    for known in rng.uniform(-5.0, 5.0, 400).tolist():
        x = np.array([x[0] + h * x[1] + 0.5 * h * h * (known + 2.0), x[1] + h * (known + 2.0)])
        exact = observe(exact, constants, float(x[0]), known, h)
        found = observe(found, constants, float(x[0]), known, h)
    size = float(np.abs(x).max(axis=0))
    # Rounding of y, 400 eps of its size, is amplified by l3 = (1 - beta)^3/h^2 = 8.6 at most.
    np.testing.assert_allclose(exact, [*x, 2.0], rtol=0.0, atol=1e-11 * size)
    np.testing.assert_allclose(found, [*x, 2.0], rtol=0.0, atol=1e-9 * size)
