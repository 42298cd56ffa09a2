"""The paper's laws as printed, as linear systems: their loops against transfer functions written from the printed equations."""

from math import sqrt

import numpy as np
import pytest

from plant.laws import hybrid, hybrid_beta3, hybrid_literal, hybrid_paper_f_hat, ladrc_printed
from plant.laws.channel import Channel
from plant.laws.hybrid import Gains
from tests.plant.axis import Axis, H, Setpoint, continuous_feedback, random_inputs, run

WO, LAMBDA, K = 12.0, 5.0, 7.2
GAINS = Gains(omega_o=WO, lambda_=LAMBDA, k1=0.0, k2=K, delta=0.1)
FREQUENCIES = [0.3, 3.0, 30.0]
# Extrapolated from h = 1e-4: error of order (omega h)^2 = 1e-5.
CLOSE = 3e-4


def polynomial(beta3: float) -> np.poly1d:
    return np.poly1d([1.0, 3.0 * WO, 3.0 * WO**2, beta3])


@pytest.mark.parametrize("omega", FREQUENCIES)
def test_literal_law_is_pd_with_kp_lambda_k_and_kd_k(omega: float) -> None:
    """C = (Q s^2 + k s + lambda k)/(1 - Q) with the measured rate; the corrected law has kd = k + lambda."""
    s = 1j * omega
    q = WO**3 / polynomial(WO**3)(s)
    for law, kd in ((hybrid_literal.LAW, K), (hybrid.LAW, K + LAMBDA)):
        expected = (q * s**2 + kd * s + LAMBDA * K) / (1.0 - q)
        assert continuous_feedback(law, GAINS, False, s) == pytest.approx(expected, rel=CLOSE)


@pytest.mark.parametrize("omega", FREQUENCIES)
def test_printed_f_hat_adds_the_estimated_rate(omega: float) -> None:
    """u = -(kp y + kd s y + z2 + z3) with z2 P = (b2 s + b3) s y + (s + b1) s u and z3 P = b3 (s^2 y - u)."""
    s = 1j * omega
    p, b1, b2, b3 = polynomial(WO**3)(s), 3.0 * WO, 3.0 * WO**2, WO**3
    from_y = LAMBDA * K + (LAMBDA + K) * s + ((b2 * s + b3) * s + b3 * s**2) / p
    from_u = ((s + b1) * s - b3) / p
    expected = from_y / (1.0 + from_u)
    assert continuous_feedback(hybrid_paper_f_hat.LAW, GAINS, False, s) == pytest.approx(expected, rel=CLOSE)


@pytest.mark.parametrize("omega", FREQUENCIES)
def test_printed_beta3_is_the_observer_of_the_printed_gains(omega: float) -> None:
    """Q = 3 wo^3/(s^3 + 3 wo s^2 + 3 wo^2 s + 3 wo^3), straight from the printed gains and not from their roots."""
    s = 1j * omega
    q = 3.0 * WO**3 / polynomial(3.0 * WO**3)(s)
    expected = (q * s**2 + (LAMBDA + K) * s + LAMBDA * K) / (1.0 - q)
    assert continuous_feedback(hybrid_beta3.LAW, GAINS, False, s) == pytest.approx(expected, rel=CLOSE)


@pytest.mark.parametrize("omega", FREQUENCIES)
def test_printed_ladrc_has_no_damping(omega: float) -> None:
    """C = (Q s^2 + ke)/(1 - Q) with ke = 2 zeta wn: no term in s but what the observer's lag makes; on z1 in place of y,
    z1 P = (b1 s^2 + b2 s + b3) y + s u.
    """
    s, gains, ke = 1j * omega, ladrc_printed.Gains(omega_n=4.0, zeta=0.9, omega_o=WO), 7.2
    p, b1, b2, b3 = polynomial(WO**3)(s), 3.0 * WO, 3.0 * WO**2, WO**3
    on_y = (b3 / p * s**2 + ke) / (1.0 - b3 / p)
    on_estimate = (ke * (b1 * s**2 + b2 * s + b3) + b3 * s**2) / p / (1.0 + (ke * s - b3) / p)
    for from_observer, expected in ((False, on_y), (True, on_estimate)):
        found = continuous_feedback(ladrc_printed.LAW, gains, from_observer, s)
        assert found == pytest.approx(expected, rel=CLOSE)


def test_the_variants_differ_from_the_corrected_law_by_what_they_say_and_by_nothing_else() -> None:
    """Same inputs, with the power term: the literal one lacks r'' - lambda e', f_hat takes z2 off."""
    inputs, channel = random_inputs(np.random.default_rng(4), 60), Channel(1.0, 0.0)
    gains = GAINS._replace(k1=3.0)
    corrected, _ = run(hybrid.LAW, gains, inputs, channel)
    literal, _ = run(hybrid_literal.LAW, gains, inputs, channel)
    missing = [i.setpoint.acceleration - LAMBDA * (i.measured.rate - i.setpoint.rate) for i in inputs]
    np.testing.assert_allclose(corrected - literal, missing, rtol=0.0, atol=1e-11 * np.abs(corrected).max(axis=0))
    f_hat, _ = run(hybrid_paper_f_hat.LAW, gains, inputs, channel)
    rates = [run(hybrid.LAW, gains, inputs[: k + 1], channel)[1].z2 for k in range(len(inputs))]
    np.testing.assert_allclose(corrected - f_hat, rates, rtol=0.0, atol=1e-11 * np.abs(corrected).max(axis=0))


def test_printed_ladrc_swings_at_the_root_of_its_gain() -> None:
    """y'' = -ke (y - 1): y = 1 - cos(sqrt(ke) t), the amplitude growing by exp(ke h t/4) because the hold is half a period late."""
    gains = ladrc_printed.Gains(omega_n=4.0, zeta=0.5, omega_o=20.0)
    flown = Axis().fly(ladrc_printed.LAW, gains, 5000, lambda t: Setpoint(1.0, 0.0, 0.0))
    t = np.arange(5000) * H
    growth = np.exp(4.0 * H * t / 4.0)
    # Second order in h is left: a phase of omega^3 h^2 t/24 and the like, 1e-3 over 20 s.
    np.testing.assert_allclose(flown.value, 1.0 - growth * np.cos(sqrt(4.0) * t), rtol=0.0, atol=5e-3)
