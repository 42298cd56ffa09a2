"""Frequency responses of designs against published closed forms and against the state space with its Pade approximant."""

from dataclasses import replace

import numpy as np
import pytest

from objectives.design.frequency import closed_matrix, mean_delays, peaks, responses
from objectives.linear_axis.channel_model import AxisLoop, Factors, RotorLag, TiltLoop, closed_loop
from plant.laws import hybrid, ladrc, pid
from tests.objectives.linear_axis.cases import HYBRID, LADRC, PID, transfer

OMEGA = np.array([0.05, 0.7, 5.0, 20.0, 90.0])
S = 1j * OMEGA
DELAY, LAG = 0.006, 0.02
ROTOR = np.exp(-DELAY * S) / (LAG * S + 1.0)


def test_loop_of_ladrc_on_the_measured_rate() -> None:
    """C = (Q s^2 + kd s + kp)/(1 - Q G_k), G_k the delayed and lagged command; facts 2.3."""
    wc, wo = 6.0, 10.0
    q = wo**3 / (S + wo) ** 3
    c = (q * S**2 + 2 * wc * S + wc**2) / (1.0 - q * ROTOR)
    np.testing.assert_allclose(responses(LADRC, S).loop(), c * ROTOR / S**2, rtol=1e-9)
    blind = replace(LADRC, actuator=replace(LADRC.actuator, lag_aware=False))
    c = (q * S**2 + 2 * wc * S + wc**2) / (1.0 - q * np.exp(-DELAY * S))
    np.testing.assert_allclose(responses(blind, S).loop(), c * ROTOR / S**2, rtol=1e-9)


def test_loop_of_pid() -> None:
    c = 60.0 + 60.0 / S + 14.0 * S / (0.005 * S + 1.0)
    np.testing.assert_allclose(responses(PID, S).loop(), c * ROTOR / S**2, rtol=1e-9)


def test_nominal_ladrc_without_lag() -> None:
    """T4: wo/wc = 5, rate from z2, no lag: Ms 1.622."""
    quick = AxisLoop("ladrc", ladrc.Gains(1.0, 1.0, 5.0), RotorLag(1e-7, 0.0), from_observer=True)
    assert peaks(quick, np.geomspace(0.01, 100.0, 8000))[0] == pytest.approx(1.622, abs=5e-4)


@pytest.mark.parametrize("power", [0.0, 12.0])
def test_a_gain_in_place_of_the_power_rate_term(power: float) -> None:
    """phi = k S makes it the hybrid with k2 + k."""
    stronger = replace(HYBRID, gains=HYBRID.gains._replace(k2=HYBRID.gains.k2 + power))
    np.testing.assert_allclose(responses(HYBRID, S, power).loop(), responses(stronger, S).loop(), rtol=1e-9)
    np.testing.assert_allclose(closed_matrix(HYBRID, power), closed_loop(stronger).a, rtol=1e-12)


@pytest.mark.parametrize("case", [LADRC, PID, HYBRID], ids=lambda case: case.law)
def test_closed_loop_is_that_of_the_state_space(case: AxisLoop) -> None:
    """At low frequency, where a Pade approximant of order 2 is exact to (w T)^5/720."""
    case = replace(case, actuator=replace(case.actuator, order=2))
    for s in (0.3j, 3.0j):
        expected = transfer(closed_loop(case).channel("reference", "value"), s)
        assert responses(case, np.array([s])).closed()[0] == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("lag_aware", [True, False])
def test_a_horizontal_axis_is_that_of_the_state_space(lag_aware: bool) -> None:
    """Through an attitude loop whose angle the law knows, or only what it asked for."""
    inner = replace(LADRC, actuator=replace(LADRC.actuator, order=2))
    outer = AxisLoop("ladrc", ladrc.Gains(0.8, 1.0, 2.0), TiltLoop(inner, lag_aware), "position")
    for s in (0.2j, 2.0j):
        expected = transfer(closed_loop(outer).channel("reference", "value"), s)
        assert responses(outer, np.array([s])).closed()[0] == pytest.approx(expected, rel=1e-6)


def test_peaks_are_those_of_the_sensitivities() -> None:
    loop = responses(LADRC, S).loop()
    ms, mt = peaks(LADRC, OMEGA)
    assert ms == pytest.approx(np.abs(1.0 / (1.0 + loop)).max(axis=0))
    assert mt == pytest.approx(np.abs(loop / (1.0 + loop)).max(axis=0))


@pytest.mark.parametrize(
    ("inner", "expected"),
    [
        # Without disturbance the observer is exact and the angle follows as wc^2/((s + wc)^2) behind the rotors... at low
        # frequency its delay is kd/kp alone, whatever the rotors do: their lag adds to a loop that is slower by itself.
        (LADRC, None),
        (replace(PID, gains=pid.Gains(60.0, 0.0, 14.0, 0.005)), 14.0 / 60.0),
        # The integral has no error on a ramp: no delay at low frequency.
        (PID, 0.0),
    ],
)
def test_mean_delays(inner: AxisLoop, expected: float | None) -> None:
    for lag_aware in (True, False):
        delivered, known = mean_delays(TiltLoop(inner, lag_aware))
        angle = responses(inner, np.array([1e-4j])).closed()[0]
        assert delivered == pytest.approx(-angle.imag / 1e-4, abs=1e-6)
        assert known == pytest.approx(delivered if lag_aware else 0.0)
        assert expected is None or delivered == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("order", [1, 2])
def test_mean_delays_of_rotors(order: int) -> None:
    assert mean_delays(RotorLag(LAG, DELAY, True, order)) == pytest.approx((LAG + DELAY, LAG + DELAY))
    assert mean_delays(RotorLag(LAG, DELAY, False, order)) == pytest.approx((LAG + DELAY, DELAY))
    assert RotorLag(LAG, DELAY, True, order).model(Factors()).a.shape == (order + 2, order + 2)


def test_laws_of_the_cases() -> None:
    assert isinstance(HYBRID.gains, hybrid.Gains)
