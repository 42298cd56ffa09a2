"""The hybrid law's sliding term against its closed forms, and its linear part against a PD law with a disturbance observer."""

from math import gamma, pi, sqrt

import numpy as np
import pytest
from scipy.integrate import quad

from plant.laws import ladrc
from plant.laws.channel import Channel
from plant.laws.hybrid import LAW, Constants, Gains, sliding_term
from tests.plant.axis import Axis, H, Setpoint, continuous_feedback, random_inputs, run

DELTA = 0.16
POWER_ONLY = LAW.prepare(Gains(omega_o=10.0, lambda_=5.0, k1=1.0, k2=0.0, delta=DELTA), H)
BOTH = LAW.prepare(Gains(omega_o=10.0, lambda_=5.0, k1=3.0, k2=2.0, delta=DELTA), H)


def describing(constants: Constants, amplitude: float) -> float:
    """First harmonic of the term for S = A sin(th), over A."""

    def integrand(angle: float) -> float:
        return sliding_term(amplitude * np.sin(angle), constants) * np.sin(angle)

    edge = [np.arcsin(DELTA / amplitude)] if amplitude > DELTA else None
    return 4.0 / (pi * amplitude) * quad(integrand, 0.0, pi / 2.0, points=edge, epsabs=1e-13, epsrel=1e-12)[0]


def test_the_sliding_term_is_odd() -> None:
    for s in (0.01, 0.16, 0.9):
        assert sliding_term(-s, BOTH) == -sliding_term(s, BOTH)
    assert sliding_term(0.0, BOTH) == 0.0


def test_the_sliding_term_is_continuous_where_saturation_sets_in() -> None:
    # Slope 1.5/sqrt(delta) before and 0.5/sqrt(delta) behind: over 2e-9 it cannot change by more than 8e-9.
    assert sliding_term(DELTA + 1e-9, POWER_ONLY) == pytest.approx(sliding_term(DELTA - 1e-9, POWER_ONLY), abs=8e-9)
    inside = (sliding_term(DELTA, POWER_ONLY) - sliding_term(DELTA - 1e-6, POWER_ONLY)) / 1e-6
    outside = (sliding_term(DELTA + 1e-6, POWER_ONLY) - sliding_term(DELTA, POWER_ONLY)) / 1e-6
    assert inside == pytest.approx(1.5 / sqrt(DELTA), rel=1e-4)
    assert outside == pytest.approx(0.5 / sqrt(DELTA), rel=1e-4)


def test_the_power_term_has_no_slope_at_zero() -> None:
    """Inside it is |S|^(3/2)/delta: its secant falls as sqrt(S)/delta, and k2 alone is left at small amplitude."""
    for s in (1e-4, 1e-6, 1e-8):
        assert sliding_term(s, POWER_ONLY) / s == pytest.approx(sqrt(s) / DELTA, rel=1e-12)
    assert sliding_term(1e-12, BOTH) / 1e-12 == pytest.approx(2.0, abs=1e-4)


def test_the_secant_is_largest_where_saturation_sets_in() -> None:
    s = np.geomspace(1e-4, 10.0, 4001)
    secants = np.array([sliding_term(x, POWER_ONLY) / x for x in s.tolist()])
    assert s[secants.argmax(axis=0)] == pytest.approx(DELTA, rel=0.01)
    assert sliding_term(DELTA, POWER_ONLY) / DELTA == pytest.approx(1.0 / sqrt(DELTA), rel=1e-12)
    assert secants.max(axis=0) <= 1.0 / sqrt(DELTA) + 1e-12


@pytest.mark.parametrize(
    ("ratio", "value"),
    [
        (0.01, 0.0915),
        (0.1, 0.2895),
        (0.5, 0.6472),
        (1.0, 0.9153),
        (1.08, 0.9265),
        (2.0, 0.7678),
        (5.0, 0.4965),
        (100.0, 0.1113),
    ],
)
def test_describing_function(ratio: float, value: float) -> None:
    """T9 and facts 3.3: n(a) = sqrt(delta) N(a delta), given to four digits."""
    assert sqrt(DELTA) * describing(POWER_ONLY, ratio * DELTA) == pytest.approx(value, abs=6e-5)


def test_describing_function_inside_and_far_outside() -> None:
    inside = 2.0 / sqrt(pi) * gamma(7 / 4) / gamma(9 / 4)
    outside = 2.0 / sqrt(pi) * gamma(5 / 4) / gamma(7 / 4)
    assert describing(POWER_ONLY, 0.5 * DELTA) == pytest.approx(inside * sqrt(0.5 * DELTA) / DELTA, rel=1e-8)
    # Far outside, what saturates is a share (delta/A)^2 of the integral.
    assert describing(POWER_ONLY, 300.0 * DELTA) == pytest.approx(outside / sqrt(300.0 * DELTA), rel=1e-4)


def test_without_the_power_term_it_is_a_pd_law_with_disturbance_observer() -> None:
    """k1 = 0: kp = lambda k2, kd = lambda + k2; as LADRC, wc = sqrt(kp) and zeta = kd/(2 wc). Same commands to rounding."""
    lam, k2, omega_o = 5.0, 7.2, 12.0
    wc = sqrt(lam * k2)
    twin = ladrc.Gains(wc, (lam + k2) / (2.0 * wc), omega_o)
    inputs = random_inputs(np.random.default_rng(5), 40)
    channel = Channel(20.0, 0.0)
    mine, _ = run(LAW, Gains(omega_o, lam, 0.0, k2, 0.1), inputs, channel)
    theirs, _ = run(ladrc.LAW, twin, inputs, channel)
    np.testing.assert_allclose(mine, theirs, rtol=0.0, atol=1e-12 * np.abs(theirs).max(axis=0))


@pytest.mark.parametrize("omega", [0.3, 3.0, 30.0])
def test_linear_part_with_the_observed_rate(omega: float) -> None:
    """Rate from z2 but y measured: u = kp y + kd z2 + z3 up to sign, with the estimates' own transfer functions.

    Continuous observer fed with u: z2 = (s y's share + u's share) of (s + wo)^3: z2 = ((b2 s + b3) s y + (s + b1) s u)/P and
    z3 = b3 (s^2 y - u)/P, from which -u/y follows.
    """
    lam, k2, wo = 5.0, 7.2, 12.0
    kp, kd, b1, b2, b3 = lam * k2, lam + k2, 3 * wo, 3 * wo**2, wo**3
    s = 1j * omega
    p = (s + wo) ** 3
    from_y = kp + (kd * (b2 * s + b3) * s + b3 * s**2) / p
    from_u = (kd * (s + b1) * s - b3) / p
    expected = from_y / (1.0 + from_u)
    found = continuous_feedback(LAW, Gains(wo, lam, 0.0, k2, 0.1), True, s)
    assert found == pytest.approx(expected, rel=3e-4)


def test_error_slides_along_the_surface() -> None:
    """Once S is driven into its band the error decays as exp(-lambda t)."""
    gains = Gains(omega_o=20.0, lambda_=2.0, k1=4.0, k2=30.0, delta=0.05)
    flown = Axis().fly(LAW, gains, 750, lambda t: Setpoint(1.0, 0.0, 0.0))
    t = np.arange(750) * H
    late = t > 1.0
    slope = np.polyfit(t[late], np.log(1.0 - flown.value[late]), 1)[0]
    assert slope == pytest.approx(-2.0, rel=0.02)
