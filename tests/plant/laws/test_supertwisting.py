"""The super-twisting term against its continuous differential equation, its sampled promises, and what Euler steps make of it."""

from math import pi, sqrt
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from plant.laws import supertwisting, supertwisting_euler
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.supertwisting import Gains, Memory, differenced
from plant.laws.twisting import (
    Twist,
    TwistConstants,
    root_size,
    root_term,
    super_twisting,
    switching_term,
    twist_constants,
)
from tests.plant.axis import Axis
from tests.plant.harness import Array


class Bare(NamedTuple):
    """What `twisting` reads of a law's constants."""

    twist: TwistConstants


REST = Twist(0.0, 0.0, 0.0)


def slide(constants: Bare, steps: int, s: float, growth: Array) -> tuple[Array, Array]:
    """S and w (K,) of S+ = S + h w + growth, growth (K,) being the integral of the disturbance over each period."""
    memory, rows = REST, []
    for k in range(steps):
        w, memory = super_twisting(memory, s, 0.0, constants)
        rows.append((s, w))
        s += constants.twist.h * w + float(growth[k])
    return tuple(np.array(rows).T)


def travel(w: Array) -> float:
    return float(np.abs(np.diff(w)).sum(axis=0))


@pytest.mark.parametrize("scale", [1.0, 10.0, 100.0])
def test_the_sliding_variable_keeps_to_h_squared_and_the_command_to_the_disturbance(scale: float) -> None:
    """T11: for d = L sin t, max |S| = L h^2 and w travels as far as d does, whatever the gains."""
    h, most = 0.01, 2.0
    constants = Bare(twist_constants(1.5 * sqrt(most * scale), 1.1 * most * scale, 0.0, h))
    t = np.arange(3001) * h
    s, w = slide(constants, 3000, 0.3, most * (np.cos(t[:-1]) - np.cos(t[1:])))
    arrived = t[:-1] > 10.0
    assert np.abs(s[arrived]).max(axis=0) == pytest.approx(most * h * h, rel=1e-3)
    assert np.abs(s[arrived]).max(axis=0) <= most * h * h * (1.0 + 1e-9)
    mean = np.diff(-most * np.cos(t)) / h  # of d over each period, which w follows one and two periods later
    assert travel(w[arrived]) == pytest.approx(travel(mean[arrived]), rel=2e-3)
    np.testing.assert_allclose(w[arrived], -mean[:-1][arrived[1:]], rtol=0.0, atol=1.01 * most * h)


@pytest.mark.parametrize("scale", [1.0, 10.0, 100.0])
def test_undisturbed_it_comes_to_rest_exactly_in_finite_time(scale: float) -> None:
    h = 0.01
    constants = Bare(twist_constants(1.5 * sqrt(scale), 1.1 * scale, 0.0, h))
    s, w = slide(constants, 3000, 0.3, np.full(3000, 0.7 * h))
    # Within one rounding of the integral, 1e-16 of 0.7: S is as small as that over 2/h.
    assert np.abs(s[1500:]).max(axis=0) < 1e-17
    np.testing.assert_allclose(w[1500:], -0.7, rtol=0.0, atol=1e-15)


def equation(_: float, state: Array, k1: float, k2: float, mu: float) -> list[float]:
    """S' = -k1 phi1 + v + 0.4, v' = -k2 phi2, with phi2 = 2 phi1 phi1'."""
    s, v = state
    root = sqrt(abs(s)) * np.sign(s)
    phi1 = root + mu * s
    slope = 0.5 / sqrt(max(abs(s), 1e-300)) + mu
    return [-k1 * phi1 + v + 0.4, -k2 * 2.0 * phi1 * slope]


@pytest.mark.parametrize("mu", [0.0, 0.6])
def test_it_tends_to_the_differential_equation(mu: float) -> None:
    """Until S first passes 0 the solution is smooth, and implicit steps approach it in proportion to h."""
    k1, k2, time = 1.5, 1.1, 0.45
    exact = solve_ivp(equation, (0.0, time), [1.0, 0.0], args=(k1, k2, mu), method="DOP853", rtol=1e-11, atol=1e-13)
    assert exact.success and exact.y[0].min(axis=0) > 0.05
    errors = []
    for h in (2e-3, 1e-3):
        steps = round(time / h)
        s, _ = slide(Bare(twist_constants(k1, k2, mu, h)), steps + 1, 1.0, np.full(steps + 1, 0.4 * h))
        errors.append(abs(s[-1] - exact.y[0, -1]))
    assert errors[0] < 5e-3
    assert errors[1] / errors[0] == pytest.approx(0.5, abs=0.03)


@pytest.mark.parametrize("mu", [0.0, 0.3, 4.0])
@pytest.mark.parametrize("h", [1e-4, 0.004, 0.1])
def test_the_implicit_equation_is_solved(mu: float, h: float) -> None:
    """z + h k1 phi1(z) + h^2 k2 phi2(z) = S, with phi2 = 2 phi1 phi1', and inside the band z = 0 with a share of the sign."""
    k1, k2 = 3.0, 7.0
    constants = Bare(twist_constants(k1, k2, mu, h))
    for s in np.geomspace(1e-12, 1e4, 60).tolist():
        z = root_size(s, constants.twist) ** 2
        if s <= h * h * k2:
            assert z == 0.0
            assert switching_term(s, constants) == pytest.approx(s / (h * h), rel=1e-12)
            assert root_term(s, constants) == pytest.approx(s / h, rel=1e-12)
            continue
        phi1 = sqrt(z) + mu * z
        phi2 = 2.0 * (1.0 / 2.0 + mu * sqrt(z)) * (1.0 + mu * sqrt(z))  # 2 phi1' phi1, sqrt(z) divided out
        assert switching_term(s, constants) == pytest.approx(k2 * phi2, rel=1e-12)
        assert root_term(s, constants) == pytest.approx(k1 * phi1 + h * k2 * phi2, rel=1e-12)
        assert z + h * k1 * phi1 + h * h * k2 * phi2 == pytest.approx(s, rel=1e-12)


def test_without_the_integral_it_arrives_at_the_closed_form() -> None:
    """k2 = 0: S' = -k1 |S|^(1/2) sgn S, so S = (S0^(1/2) - k1 t/2)^2 until it stays at 0."""
    h, k1 = 1e-4, 2.0
    s, _ = slide(Bare(twist_constants(k1, 0.0, 0.0, h)), 8000, 0.25, np.zeros(8000))
    t = np.arange(8000) * h
    np.testing.assert_allclose(s, np.maximum(0.5 - 0.5 * k1 * t, 0.0) ** 2, rtol=0.0, atol=3.0 * k1 * k1 * h * 0.25)
    assert abs(s[-1]) < (k1 * h) ** 2


def harmonic_balance(k1: float, k2: float, lag: float) -> tuple[float, float]:
    """Amplitude and frequency at which S' = x, lag x' + x = w balances the first harmonic of w: 1 + N/(s (lag s + 1)) = 0."""
    root = 2.0 / pi * quad(lambda th: sqrt(np.sin(th)) * np.sin(th), 0.0, pi)[0]  # of |sin|^(1/2) sgn sin
    switched = 2.0 / pi * quad(np.sin, 0.0, pi)[0]  # of sgn sin, then integrated by 1/(j omega)
    # Imaginary part: omega^2 = k2 switched/A. Real part: lag omega^2 = k1 root/A^(1/2).
    omega = k1 * root / (lag * sqrt(k2 * switched))
    return k2 * switched / omega**2, omega


@pytest.mark.parametrize(("k1", "k2", "lag"), [(1.5, 1.1, 0.05), (4.0, 3.0, 0.02)])
def test_an_actuator_lag_leaves_the_limit_cycle_of_the_harmonic_balance(k1: float, k2: float, lag: float) -> None:
    """T10: amplitude and frequency within 1 %; A = 1.309 (lag k2/k1)^2 and omega = 0.986 k1/(lag k2^(1/2))."""
    amplitude, omega = harmonic_balance(k1, k2, lag)
    assert amplitude == pytest.approx(1.309 * (lag * k2 / k1) ** 2, rel=1e-3)
    assert omega == pytest.approx(0.986 * k1 / (lag * sqrt(k2)), rel=1e-3)
    h = 2.0 * pi / omega / 3000  # steps add half of h to the lag
    constants, memory = Bare(twist_constants(k1, k2, 0.0, h)), REST
    s, x, steps, fading = amplitude, 0.0, 75000, float(np.exp(-h / lag))
    path = np.empty(steps)
    for k in range(steps):
        path[k] = s
        w, memory = super_twisting(memory, s, 0.0, constants)
        s, x = s + h * w + (x - w) * lag * (1.0 - fading), w + (x - w) * fading
    late = path[steps // 2 :]
    upward = np.nonzero((late[:-1] < 0.0) & (late[1:] >= 0.0))[0]
    period = h * float(upward[-1] - upward[0]) / (len(upward) - 1)
    assert 2.0 * pi / period == pytest.approx(omega, rel=0.01)
    assert np.abs(late).max(axis=0) == pytest.approx(amplitude, rel=0.01)


def chatter(law: Any, scale: float, h: float = 0.004) -> tuple[float, float]:
    """Travel of the command per second and size of S once arrived, under a constant disturbance."""
    gains = Gains(3.0, 1.5 * sqrt(scale), 1.1 * scale)
    flown = Axis(disturbance=0.7).fly(law, gains, 4000, lambda t: Setpoint(0.01, 0.0, 0.0), h=h)
    s = flown.rate + 3.0 * (flown.value - 0.01)
    return travel(flown.command[-1000:]) / (1000 * h), float(np.abs(s[-1000:]).max(axis=0))


def test_chatter_of_euler_steps_grows_with_the_gains_and_the_implicit_steps_have_none() -> None:
    """v alone travels k2 per second in Euler steps, and |S| is of order k1^2 h^2."""
    euler = np.array([chatter(supertwisting_euler.LAW, scale) for scale in (1.0, 10.0, 100.0)])
    np.testing.assert_allclose(euler[1:, 0] / euler[:-1, 0], 10.0, rtol=0.25)
    assert euler[0, 0] > 0.9 * 1.1
    np.testing.assert_allclose(euler[:, 1] / (2.25 * np.array([1.0, 10.0, 100.0]) * 0.004**2), 0.3, atol=0.2)
    for scale in (1.0, 10.0, 100.0):
        assert chatter(supertwisting.LAW, scale)[0] < 1e-9


@pytest.mark.parametrize("mu", [0.0, 0.5])
def test_what_saturation_keeps_from_the_pull_is_not_integrated(mu: float) -> None:
    """Nothing of the pull delivered: v is as before. Half of it: half. More than asked for, or all: as unsaturated."""
    constants = Bare(twist_constants(3.0, 7.0, mu, 0.004))
    for s in (0.4, -0.4, 1e-5):
        w, after = super_twisting(Twist(0.2, 0.0, 0.0), s, 0.0, constants)
        assert after.pull == pytest.approx(0.2 - w, rel=1e-12)
        step = after.v - 0.2
        assert step * s < 0.0
        for delivered, kept in ((0.0, 0.0), (0.5, 0.5), (1.0, 1.0), (1.7, 1.0), (-3.0, 0.0)):
            excess = after.pull * (1.0 - delivered)
            _, then = super_twisting(after, 0.0, excess, constants)
            assert then.v - 0.2 == pytest.approx(kept * step, rel=1e-9, abs=1e-15)


def test_a_command_held_at_its_limit_does_not_wind_the_integral_up() -> None:
    """Asked to go where the limit cannot take it, v ends within what was delivered, not at k2 times the time waited."""
    gains = Gains(2.0, 3.0, 5.0)
    flown = Axis(disturbance=-3.0, limit=1.0).fly(supertwisting.LAW, gains, 500, lambda t: Setpoint(1.0, 0.0, 0.0))
    assert (flown.command[5:] == 1.0).all()
    assert 0.0 <= flown.memory.twist.v < 1.0
    deaf = Axis(disturbance=-3.0, limit=1.0, is_aware=False).fly(
        supertwisting.LAW, gains, 500, lambda t: Setpoint(1.0, 0.0, 0.0)
    )
    assert deaf.memory.twist.v == pytest.approx(5.0 * 500 * 0.004, rel=0.01)


def test_the_differenced_rate_is_exact_once_v_has_found_the_disturbance() -> None:
    h, y, rate, command, disturbance = 0.01, 0.4, -0.3, 2.0, -0.8
    acceleration = 3.0 * command + disturbance
    after = Measured(y + h * rate + 0.5 * h * h * acceleration, 99.0)
    memory = Memory(Twist(-disturbance, 0.0, 0.0), y)
    found = differenced(memory, Channel(3.0, 1.0), after, Applied(command, 0.0), h)
    assert found == pytest.approx(rate + h * acceleration, rel=1e-12)
