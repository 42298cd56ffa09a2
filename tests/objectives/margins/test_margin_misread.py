"""A closed loop read as if it were the open one, as a tuning tool once did: python-control puts the same loop together.

The case of pull request 5406 of betaflight-configurator, built anew from our model: 163 deg were told of loops that have half of
it, and a recommendation by phase margin alone took Ms beyond 3.
"""

from collections.abc import Callable
from functools import cache
from math import degrees, radians
from typing import Any

import control
import numpy as np
import pytest
from scipy import signal

from objectives.margins.margins import MarginModel
from objectives.margins.quantities import QUANTITIES
from objectives.margins.results import Margins
from objectives.margins.trim import Trim
from plant.law_registry import LAWS
from plant.loop import Timing
from plant.quadrotor.airframes import load
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.gains import airframe_gains, default_row, gain_addresses
from plant.quadrotor.nominal import ControlOptions, nominal
from tests.objectives.margins.python_control import Loop, classical
from tuner.analysis.margins.limits import LIMITS

# scipy tells pyright less than it knows.
discrete: Any = signal.cont2discrete
H, LAG, ROLL = 0.00025, 0.010, 3
# The racer with small propellers, which follow in a third of the time.
VEHICLE = load("racer5").vehicle._replace(lag_up=LAG, lag_down=LAG)
# Filters, level gain and no attenuation by throttle.
FILTERS = {
    "tpa_rate": 0.0,
    "gyro_lpf1": 500.0,
    "gyro_lpf2": 500.0,
    "d_lpf1": 100.0,
    "d_lpf2": 200.0,
    "angle_cutoff": 50.0,
    "angle_p": 50.0,
}
FLOWN = {"p": 112.0, "i": 39.0, "d": 55.0}
RECOMMENDED = {"p": 246.0, "i": 86.0, "d": 55.0}
"""P and I 2.2 times as large, D as it was."""
GRID = np.geomspace(2.0, np.pi / H, 800)
ONE: Any = control.tf([1.0], [1.0], H)
BACK: Any = control.tf([1.0], [1.0, 0.0], H)


def stage(cutoff: float) -> Any:
    """First-order low-pass by backward Euler."""
    return 1.0 / (ONE + (ONE - BACK) / (2.0 * np.pi * cutoff * H))


def moved(order: int) -> Any:
    """Rate (order 1) [deg/s] or angle (order 2) [deg] for a command that acts one period late, held."""
    a, b = np.diag(np.ones(order), -1), np.zeros((order + 1, 1))
    a[0, 0], b[0, 0] = -1.0 / LAG, 1.0 / LAG
    ad, bd, *_ = discrete((a, b, np.eye(order + 1), 0.0 * b), H)
    authority = degrees(airframe_gains(model().cascade, VEHICLE)["roll.authority"])
    return control.ss2tf(control.ss(ad, bd, [[*[0.0] * order, authority]], [[0.0]], H)) * BACK


@cache
def parts(**gains: float) -> tuple[Any, Any, Any]:
    """Return P and I, then D, on deg/s, and the rate for a command, behind the gyro's filters [deg/s]."""
    integrator = H / (ONE - BACK)
    on_error = 0.032029 * gains["p"] * ONE + 0.244381 * gains["i"] * integrator
    damping = 0.000529 * gains["d"] * stage(FILTERS["d_lpf1"]) * stage(FILTERS["d_lpf2"]) * (ONE - BACK) / H
    return on_error, damping, moved(1) * stage(FILTERS["gyro_lpf1"]) * stage(FILTERS["gyro_lpf2"])


def closed(gains: dict[str, float]) -> Callable[[Any], Any]:
    """Return T(z) from the rate asked for to the filtered gyro, which a chirp on the stick measures."""
    on_error, damping, turning = parts(**gains)
    return lambda z: on_error(z) * turning(z) / (1.0 + (on_error(z) + damping(z)) * turning(z))


def at_error(gains: dict[str, float]) -> Callable[[Any], Any]:
    """Return L = T/(1 - T), the open loop that can be had from T: broken at the rate error, with D's own loop closed."""
    t = closed(gains)
    return lambda z: t(z) / (1.0 - t(z))


def at_motors(gains: dict[str, float]) -> Callable[[Any], Any]:
    """Return the open loop broken at the command to the motors, with the level gain around it."""
    on_error, damping, turning = parts(**gains)
    faster = FILTERS["angle_cutoff"] / np.sqrt(2.0 ** (1.0 / 3.0) - 1.0)
    # The angle that the controller sees has not gone through the gyro's filters.
    level = 0.1 * FILTERS["angle_p"] * stage(faster) ** 3 * moved(2)
    return lambda z: (on_error(z) + damping(z)) * turning(z) + on_error(z) * level(z)


def reading(gains: dict[str, float]) -> float:
    """Return 180 deg plus the phase [deg] where the closed loop's gain first falls through 1: what was told as a phase margin."""
    t = Loop(closed(gains), H, GRID)
    there = int(np.argmax(np.abs(t.on_grid) < 1.0))
    return 180.0 + degrees(np.angle(t(t.refined(lambda value: np.log(np.abs(value)), GRID[there]))))


def phase_margin(system: Callable[[Any], Any]) -> float:
    """Return the phase margin [deg]."""
    return degrees(classical(Loop(system, H, GRID))["phase"])


def peak(system: Callable[[Any], Any]) -> float:
    """Return Ms."""
    return 1.0 / float(Loop(system, H, GRID).least(lambda value: np.abs(1.0 + value)))


@cache
def model() -> MarginModel:
    cascade = close_cascade(LAWS["pid"], LAWS["betaflight"])
    known = nominal(VEHICLE, ControlOptions(delay=True), H)
    return MarginModel(cascade, known, Timing(H, H), VEHICLE, Trim(hold=False))


def margins_of(gains: dict[str, float]) -> Margins:
    """Return our margins of the vehicle in angle mode."""
    row = default_row(model().cascade, VEHICLE)
    for gain in gain_addresses(model().cascade):
        if gain.axis in ("roll", "pitch"):
            row[gain.column] = {**FILTERS, **gains}.get(gain.info.name, row[gain.column])
    return model().evaluate(np.array(row)[None])


def test_the_closed_loop_read_as_the_open_one_says_163_deg_of_either() -> None:
    assert reading(FLOWN) == pytest.approx(163.0, abs=1.0)
    assert reading(RECOMMENDED) == pytest.approx(163.0, abs=1.0)
    assert phase_margin(at_error(FLOWN)) == pytest.approx(78.5, abs=0.5)


@pytest.mark.parametrize("gains", [FLOWN, RECOMMENDED], ids=["flown", "recommended"])
def test_our_margins_are_those_of_the_loop_at_the_motors(gains: dict[str, float]) -> None:
    found, loop = margins_of(gains), Loop(at_motors(gains), H, GRID)
    wanted = classical(loop)
    assert found.stable[0, ROLL]
    assert found.phase.value[0, ROLL] == pytest.approx(wanted["phase"], rel=1e-6)
    assert found.gain_up.value[0, ROLL] == pytest.approx(wanted["gain_up"], rel=1e-6)
    assert found.sensitivity.value[0, ROLL] == pytest.approx(peak(at_motors(gains)), rel=1e-6)


def test_a_recommendation_with_its_phase_margin_is_refused_for_what_ms_became() -> None:
    """56 deg where the tool aims at 50 to 72; the usual limits take what flew, and neither Ms nor phase of what was recommended."""
    assert radians(phase_margin(at_error(RECOMMENDED))) == pytest.approx(radians(56.0), abs=radians(0.5))
    before, after = (broken(margins_of(gains)) for gains in (FLOWN, RECOMMENDED))
    assert before == set()
    assert after == {"ms", "phase_margin"}
    assert margins_of(RECOMMENDED).sensitivity.value[0, ROLL] > 3.0


def broken(margins: Margins) -> set[str]:
    """Return the usual limits that roll breaks."""
    known = {limit: QUANTITIES[limit.quantity] for limit in LIMITS}
    values = {limit: entry.to_limit(entry.values(margins))[0, ROLL] for limit, entry in known.items()}
    return {limit.quantity for limit, value in values.items() if not limit.is_satisfied(float(value))}
