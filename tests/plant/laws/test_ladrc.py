"""LADRC against its published transfer functions and a matrix form of its observer."""

import numpy as np
import pytest

from plant.laws.channel import Channel
from plant.laws.ladrc import LAW, Gains
from tests.plant.axis import Axis, H, Setpoint, continuous_feedback, linearised, random_inputs, run

GAINS = Gains(omega_c=4.0, zeta=0.8, omega_o=15.0)
KP, KD = 16.0, 6.4
B1, B2, B3 = 45.0, 675.0, 3375.0
FREQUENCIES = [0.1, 1.0, 5.0, 20.0, 100.0]


@pytest.mark.parametrize("omega", FREQUENCIES)
def test_feedback_on_estimates_is_the_published_transfer_function(omega: float) -> None:
    """Facts 2.3: C_fb = ((kp b1 + kd b2 + b3) s^2 + (kp b2 + kd b3) s + kp b3)/(s (s^2 + (b1 + kd) s + b2 + kd b1 + kp))."""
    s = 1j * omega
    top = (KP * B1 + KD * B2 + B3) * s**2 + (KP * B2 + KD * B3) * s + KP * B3
    expected = top / (s * (s**2 + (B1 + KD) * s + B2 + KD * B1 + KP))
    # Extrapolated from h = 1e-4: error of order (omega h)^2 = 1e-4 at most.
    assert continuous_feedback(LAW, GAINS, True, s) == pytest.approx(expected, rel=3e-4)


@pytest.mark.parametrize("omega", FREQUENCIES)
def test_feedback_on_measured_rate_is_the_published_transfer_function(omega: float) -> None:
    """C = (Q s^2 + kd s + kp)/(1 - Q) with Q = b3/(s + wo)^3."""
    s = 1j * omega
    q = B3 / (s + 15.0) ** 3
    expected = (q * s**2 + KD * s + KP) / (1.0 - q)
    assert continuous_feedback(LAW, GAINS, False, s) == pytest.approx(expected, rel=3e-4)


def test_integral_action_at_low_frequency() -> None:
    """C -> k_i/s with k_i = kp b3/(b2 + kd b1 + kp) on estimates and kp wo/3 with the measured rate."""
    s = 1e-4j
    on_estimates, on_rate = (s * continuous_feedback(LAW, GAINS, flag, s) for flag in (True, False))
    assert on_estimates.real == pytest.approx(KP * B3 / (B2 + KD * B1 + KP), rel=1e-3)
    assert on_rate.real == pytest.approx(KP * 15.0 / 3.0, rel=1e-3)


def test_step_response_is_that_of_the_chosen_bandwidth() -> None:
    # Without disturbance the observer is exact and y'' = wc^2 (r - y) - 2 wc y': y = 1 - (1 + wc t) e^(-wc t). The
    # hold delays by h/2: an error of order wc h/2 = 0.4 % of the slope's peak wc/e.
    flown = Axis().fly(LAW, Gains(2.0, 1.0, 20.0), 1000, lambda t: Setpoint(1.0, 0.0, 0.0))
    t = np.arange(1000) * H
    np.testing.assert_allclose(flown.value, 1.0 - (1.0 + 2.0 * t) * np.exp(-2.0 * t), rtol=0.0, atol=0.003)


def test_commands_are_those_of_the_matrix_form() -> None:
    """Facts 2.4: zp = Phi z + Gam u, z = zp + Lc (y - zp1), u = (kp (r - z1) + kd (r' - z2) + r'' - z3)/b0."""
    b0, beta = 3.0, np.exp(-15.0 * H)
    phi = np.array([[1.0, H, H * H / 2.0], [0.0, 1.0, H], [0.0, 0.0, 1.0]])
    gamma = b0 * np.array([H * H / 2.0, H, 0.0])
    gain = np.array([1 - beta**3, 3 * (1 - beta) ** 2 * (1 + beta) / (2 * H), (1 - beta) ** 3 / H**2])
    inputs = random_inputs(np.random.default_rng(1), 40)
    z = np.array([inputs[0].measured.value, inputs[0].measured.rate, 0.0])
    expected = []
    for setpoint, measured, applied in inputs:
        predicted = phi @ z + gamma * applied.effect
        z = predicted + gain * (measured.value - predicted[0])
        expected.append((np.array([KP, KD, 1.0]) @ (np.array(setpoint) - [z[0], z[1], 0.0]) - z[2]) / b0)
    found, _ = run(LAW, GAINS, inputs, Channel(b0, 1.0))
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-11 * np.abs(expected).max(axis=0))


def test_estimate_of_disturbance_stays_at_zero_through_saturation() -> None:
    """The observer is fed with what is delivered, so a clipped command is not taken for a disturbance."""
    flown = Axis(limit=0.3).fly(LAW, GAINS, 500, lambda t: Setpoint(1.0, 0.0, 0.0))
    assert np.abs(flown.unlimited).max(axis=0) > 1.0
    # Rounding of y near 1, amplified by l3 = (1 - beta)^3/h^2 = 12.
    assert abs(flown.memory.z3) < 1e-11


def test_the_law_is_linear() -> None:
    """The matrices found from unit steps reproduce the response to any inputs."""
    inputs = random_inputs(np.random.default_rng(2), 30)
    channel = Channel(2.0, 1.0)
    system = linearised(LAW, GAINS, channel, H)
    state = np.array([inputs[0].measured.value, inputs[0].measured.rate, 0.0])
    expected = []
    for case in inputs:
        row = np.array([leaf for part in case for leaf in part])
        expected.append(system.c @ state + system.d @ row)
        state = system.a @ state + system.b @ row
    found, _ = run(LAW, GAINS, inputs, channel)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-11 * np.abs(expected).max(axis=0))
