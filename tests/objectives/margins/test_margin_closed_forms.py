"""Margins of LADRC on a double integrator, known in closed form, as limits of ever faster sampling."""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from objectives.scales import decibel
from plant.loop import Timing
from plant.quadrotor.nominal import ControlOptions
from tests.objectives.margins.designs import gains_with, ideal_vehicle, model_of

# wo/wc: Ms, phase margin [deg], gain crossover over wc, upper gain margin [dB], delay margin times wc, without any lag and with
# kd = 2 wc, to the digits given.
CLOSED_FORM = {
    1.0: (1.953, 31.9, 1.00, 11.6, 0.557),
    2.0: (1.867, 33.7, 1.52, 12.2, 0.387),
    3.0: (1.763, 36.4, 1.96, 12.9, 0.325),
    5.0: (1.622, 41.24, 2.735, 14.2, 0.263),
    10.0: (1.472, 49.2, 4.49, 15.9, 0.191),
    20.0: (1.382, 56.9, 7.82, 17.2, 0.127),
}
YAW = 5
PERIODS = (4e-3, 2e-3, 1e-3, 0.5e-3)


def without_sampling(at_period):
    """Numbers at a period of 0, by Richardson's extrapolation: errors of order h, then h^2, then h^3 drop out."""
    table = [at_period(h) for h in PERIODS]
    for order in (1, 2, 3):
        table = [
            (2.0**order * fine - coarse) / (2.0**order - 1.0) for coarse, fine in zip(table, table[1:], strict=False)
        ]
    return table[0]


def digits(value):
    """Half a unit of the last digit of a number as printed."""
    return 0.5 * 10.0 ** -len(str(value).partition(".")[2])


@pytest.mark.parametrize("ratio", CLOSED_FORM)
def test_margins_tend_to_the_table(ratio):
    def at_period(h):
        """Rotors lag half a period, so that they do not in the limit."""
        options = ControlOptions(attitude_rate="observer", lag_aware=False)
        model = model_of("ladrc", "ladrc", options, vehicle=ideal_vehicle(0.5 * h), timing=Timing(h, h))
        m = model.evaluate(gains_with("ladrc", "ladrc", yaw__omega_c=1.0, yaw__omega_o=ratio))
        parts = (m.sensitivity, m.phase, m.crossover, m.gain_up, m.delay)
        return np.array([part.value[0, YAW] for part in parts])

    peak, phase, crossover, rise, delay = without_sampling(at_period)
    wanted = CLOSED_FORM[ratio]
    for got, exact in zip((peak, np.degrees(phase), crossover, decibel(rise), delay), wanted, strict=True):
        assert got == pytest.approx(exact, abs=1.1 * digits(exact))


WC, WO, LAG = 6.0, 10.0, 0.02
# How the law takes its rate and what its observer is fed with.
STRUCTURES = {
    "rate from the observer": ControlOptions(attitude_rate="observer", lag_aware=False),
    "rate from the gyro": ControlOptions(lag_aware=False),
    "observer that knows the lag": ControlOptions(lag_aware=True),
}


def loop_transfer(structure, s):
    """L(s) = C(s)/s^2/(lag s + 1), with C of the law in acceleration units."""
    kp, kd, (b1, b2, b3) = WC**2, 2.0 * WC, (3.0 * WO, 3.0 * WO**2, WO**3)
    actuator = 1.0 / (LAG * s + 1.0)
    if structure == "rate from the observer":
        top = (kp * b1 + kd * b2 + b3) * s**2 + (kp * b2 + kd * b3) * s + kp * b3
        law = top / (s * (s**2 + (b1 + kd) * s + b2 + kd * b1 + kp))
    else:
        q = b3 / (s**3 + b1 * s**2 + b2 * s + b3)
        known = actuator if structure == "observer that knows the lag" else 1.0
        law = (q * s**2 + kd * s + kp) / (1.0 - q * known)
    return law * actuator / s**2


def exact_margins(structure):
    """Margins of the closed form by roots and minima of a library."""
    loop = lambda w: loop_transfer(structure, 1j * w)  # noqa: E731
    grid = np.geomspace(0.05, 500.0, 4000)
    points = loop(grid)

    def roots(f):
        values = f(points)
        at = np.nonzero(np.signbit(values[1:]) != np.signbit(values[:-1]))[0]
        return np.array([brentq(lambda w: float(f(loop(w))), grid[i], grid[i + 1], xtol=1e-13) for i in at])

    def least(f):
        i = int(np.argmin(f(points)))
        found: Any = minimize_scalar(
            lambda w: float(f(loop(w))), bounds=(grid[i - 1], grid[i + 1]), method="bounded", options={"xatol": 1e-9}
        )
        return found.fun

    turned = roots(np.imag)
    gains = -1.0 / loop(turned).real
    crossed = roots(lambda z: np.log(np.abs(z)))
    lag = np.mod(np.angle(loop(crossed)) + np.pi, 2.0 * np.pi)
    return {
        "gain_up": min(gains[gains > 1.0], default=np.inf),
        "gain_down": 1.0 / max(gains[(gains > 0.0) & (gains < 1.0)], default=0.0) if any(gains < 1.0) else np.inf,
        "phase": min(np.minimum(lag, 2.0 * np.pi - lag)),
        "delay": min(lag / crossed),
        "crossover": max(crossed),
        "sensitivity": 1.0 / least(lambda z: np.abs(1.0 + z)),
        "complementary": 1.0 / least(lambda z: np.abs(1.0 + 1.0 / z)),
        "disk": 2.0 * least(lambda z: np.abs((1.0 + z) / (1.0 - z))),
    }


# Load-disturbance index: integral gain of each law.
LOAD_INDEX = {
    "rate from the observer": WC**2 * WO**3 / (3.0 * WO**2 + 2.0 * WC * 3.0 * WO + WC**2),
    "rate from the gyro": WC**2 * WO / 3.0,
    "observer that knows the lag": WC**2 / (3.0 / WO + LAG),
}


@pytest.mark.parametrize("structure", STRUCTURES)
def test_every_margin_tends_to_that_of_the_continuous_law(structure):
    wanted = exact_margins(structure) | {"load_index": LOAD_INDEX[structure]}
    # With sampling every loop has a highest gain; one that goes to infinity with the rate of sampling is no limit.
    wanted = {name: value for name, value in wanted.items() if np.isfinite(value)}
    assert len(wanted) >= 7

    def at_period(h):
        model = model_of("ladrc", "ladrc", STRUCTURES[structure], vehicle=ideal_vehicle(LAG), timing=Timing(h, h))
        m = model.evaluate(gains_with("ladrc", "ladrc", yaw__omega_c=WC, yaw__omega_o=WO))
        return np.array([getattr(m, name).value[0, YAW] for name in wanted])

    # What is left of the extrapolation is of order (PERIODS[0] times the fastest pole)^4 = 0.2^4, less its binomials of 64.
    np.testing.assert_allclose(without_sampling(at_period), list(wanted.values()), rtol=3e-5)
