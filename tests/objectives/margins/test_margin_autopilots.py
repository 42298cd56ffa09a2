"""Loops of autopilots: margins hold every filter exactly, against loop transfer functions put together from scipy's own filters."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import signal as scipy_signal

from objectives.margins.margins import MarginModel
from objectives.margins.trim import Trim
from plant.law_registry import LAWS
from plant.loop import Timing
from plant.quadrotor.cascade import Cascade, close_cascade
from plant.quadrotor.gains import default_row, gain_addresses
from plant.quadrotor.nominal import ControlOptions, nominal
from tests.objectives.margins.designs import ideal_vehicle

# scipy tells pyright less than it knows.
signal: Any = scipy_signal
Array = NDArray[np.float64]
# Responses; numpy does not tell pyright which of them are complex.
Complex = Any

LAG = 0.03
VEHICLE = ideal_vehicle(LAG)
LEVEL = Trim(hold=False)


def filtered(ba: tuple[Array, Array], w: Array, h: float) -> Complex:
    return np.asarray(signal.freqz(*ba, w * h)[1])


def low_pass(cutoff: float, w: Array, h: float) -> Complex:
    return filtered(signal.butter(2, cutoff, fs=1.0 / h), w, h)


def px4(gains: dict[str, float], w: Array, h: float) -> tuple[Complex, Complex]:
    """Return what PX4 commands, in acceleration, for an angle and for a rate."""
    z = np.exp(1j * w * h)
    notch = filtered(signal.iirnotch(gains["notch"], gains["notch"] / gains["notch_width"], fs=1.0 / h), w, h)
    on_error = gains["p"] + h * gains["i"] / (z - 1.0)
    on_asked = on_error + gains["ff"]
    gyro = low_pass(gains["gyro_cutoff"], w, h) * notch
    on_rate = gyro * (on_error + gains["d"] * stage(gains["d_cutoff"], w, h) * (1.0 - 1.0 / z) / h)
    return gains["authority"] * on_asked * gains["angle_p"], gains["authority"] * on_rate


def stage(cutoff: float, w: Array, h: float) -> Complex:
    """Return a first-order low-pass by backward Euler: 1/(1 + s/w_c) with s = (1 - 1/z)/h."""
    return 1.0 / (1.0 + (1.0 - np.exp(-1j * w * h)) / (h * 2.0 * np.pi * cutoff))


def ardupilot(gains: dict[str, float], w: Array, h: float) -> tuple[Complex, Complex]:
    """Return what ArduPilot commands, in acceleration, for an angle and for a rate; it integrates before use."""
    z = np.exp(1j * w * h)
    derivative = gains["d"] * stage(gains["d_cutoff"], w, h) * (1.0 - 1.0 / z) / h
    on_error = (gains["p"] + h * gains["i"] / (1.0 - 1.0 / z) + derivative) * stage(gains["error_cutoff"], w, h)
    on_asked = (on_error + gains["ff"]) * stage(gains["target_cutoff"], w, h)
    on_rate = on_error * low_pass(gains["gyro_cutoff"], w, h)
    return gains["authority"] * on_asked * gains["angle_p"], gains["authority"] * on_rate


def betaflight(gains: dict[str, float], w: Array, h: float) -> tuple[Complex, Complex]:
    """Return what Betaflight commands, in acceleration, for an angle and for a rate."""
    z, degrees = np.exp(1j * w * h), 180.0 / np.pi
    centre, lower = gains["notch"], gains["notch_cutoff"]
    # Q of a notch with this lower edge; RBJ's cookbook gives the section.
    alpha = np.sin(2.0 * np.pi * centre * h) / 2.0 * (centre**2 - lower**2) / (centre * lower)
    turn = -2.0 * np.cos(2.0 * np.pi * centre * h)
    notch = filtered((np.array([1.0, turn, 1.0]), np.array([1.0 + alpha, turn, 1.0 - alpha])), w, h)
    gyro = stage(gains["gyro_lpf1"], w, h) * stage(gains["gyro_lpf2"], w, h) * notch
    on_error = degrees * (0.032029 * gains["p"] + 0.244381 * gains["i"] * h / (1.0 - 1.0 / z))
    # Throttle that hovers, above the breakpoint: D is attenuated.
    share = 0.01 * gains["tpa_rate"] * (gains["throttle"] - 0.3) / (1.0 - 0.3)
    derivative = (
        degrees * 0.000529 * gains["d"] * (1.0 - share) * stage(gains["d_lpf1"], w, h) * stage(gains["d_lpf2"], w, h)
    )
    on_rate = gyro * (on_error + derivative * (1.0 - 1.0 / z) / h)
    level = 0.1 * gains["angle_p"] * stage(1.0 / np.sqrt(2.0 ** (1.0 / 3.0) - 1.0) * 50.0, w, h) ** 3
    return gains["authority"] * on_error * level, gains["authority"] * on_rate


def crazyflie(gains: dict[str, float], w: Array, h: float) -> tuple[Complex, Complex]:
    """Return what the Crazyflie commands, in acceleration, for an angle and for a rate."""
    z, degrees = np.exp(1j * w * h), 180.0 / np.pi
    gyro = low_pass(gains["gyro_cutoff"], w, h)
    on_error = gains["p"] + gains["i"] * h / (1.0 - 1.0 / z)
    on_rate = gyro * (on_error + gains["d"] * low_pass(gains["d_cutoff"], w, h) * (1.0 - 1.0 / z) / h)
    outer = gains["angle_p"] + gains["angle_i"] * h / (1.0 - 1.0 / z) + gains["angle_d"] * (1.0 - 1.0 / z) / h
    unit = gains["authority"] * degrees
    return unit * (on_error + gains["ff"]) * outer, unit * on_rate


FORMS: dict[str, Callable[..., tuple[Complex, Complex]]] = {
    "px4": px4,
    "ardupilot": ardupilot,
    "betaflight": betaflight,
    "crazyflie": crazyflie,
}
CHOSEN = {
    "ardupilot": {"ff": 0.01, "error_cutoff": 45.0, "gyro_cutoff": 35.0, "authority": 120.0, "d": 0.002},
    "betaflight": {"notch": 100.0, "notch_cutoff": 80.0, "authority": 0.2, "tpa_breakpoint": 1300.0, "throttle": 0.7},
    "crazyflie": {"angle_d": 0.02, "d_cutoff": 40.0, "ff": 3.0, "authority": 1e-3},
    "px4": {"ff": 0.02, "notch": 90.0, "notch_width": 25.0, "d_cutoff": 45.0, "authority": 150.0},
}


def expected_loop(name: str, gains: dict[str, float], w: Array, h: float) -> Complex:
    """Return the loop transfer function with a lagging torque, held, on a free axis."""
    a = np.array([[-1.0 / LAG, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    b = np.array([[1.0 / LAG], [0.0], [0.0]])
    ad, bd, *_ = signal.cont2discrete((a, b, np.eye(3), np.zeros((3, 1))), h)
    z = np.exp(1j * w * h)
    state = np.linalg.solve(z[:, None, None] * np.eye(3) - ad, np.broadcast_to(bd, (len(z), 3, 1)))[..., 0]
    on_angle, on_rate = FORMS[name](gains, w, h)
    return on_angle * state[:, 2] + on_rate * state[:, 1]


def rows_of(cascade: Cascade, chosen: dict[str, float]) -> Array:
    row = default_row(cascade)
    for gain in gain_addresses(cascade):
        if gain.loop == "attitude":
            row[gain.column] = chosen.get(gain.info.name, row[gain.column])
    return np.array(row)


def gains_of(cascade: Cascade, row: Array, axis: str) -> dict[str, float]:
    return {gain.info.name: float(row[gain.column]) for gain in gain_addresses(cascade) if gain.axis == axis}


@pytest.mark.parametrize("h", [0.004, 0.001])
@pytest.mark.parametrize("name", FORMS)
def test_the_loop_is_that_of_scipys_filters(name: str, h: float) -> None:
    cascade, timing = close_cascade(LAWS["pid"], LAWS[name], 4), Timing(h, min(h, 0.001))
    model = MarginModel(cascade, nominal(VEHICLE, ControlOptions(), h), timing, VEHICLE, LEVEL)
    row = rows_of(cascade, CHOSEN[name])
    w = np.geomspace(0.5, 0.9 * np.pi / h, 60)
    found = model.loop(row, "roll", frequency=w).loop
    np.testing.assert_allclose(found, expected_loop(name, gains_of(cascade, row, "roll"), w, h), rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("name", FORMS)
def test_phase_margins_are_those_of_the_independent_loop(name: str) -> None:
    h = 0.001
    cascade = close_cascade(LAWS["pid"], LAWS[name])
    model = MarginModel(cascade, nominal(VEHICLE, ControlOptions(), h), Timing(h, h), VEHICLE, LEVEL)
    row = rows_of(cascade, CHOSEN[name])
    found = model.evaluate(row[None])
    w = np.array([found.crossover.value[0, 3]])
    there = expected_loop(name, gains_of(cascade, row, "roll"), w, h)
    assert found.stable[0, 3] and abs(there[0]) == pytest.approx(1.0, abs=1e-6)
    assert found.phase.value[0, 3] == pytest.approx(abs(np.angle(-there[0])), abs=1e-6)


@pytest.mark.parametrize("name", FORMS)
def test_group_delay_and_rejection_bandwidth_are_read_off_the_independent_loop(name: str) -> None:
    """By differences of the phase about the crossover, and where |1/(1 + L)| comes up through -3 dB."""
    h = 0.001
    cascade = close_cascade(LAWS["pid"], LAWS[name])
    model = MarginModel(cascade, nominal(VEHICLE, ControlOptions(), h), Timing(h, h), VEHICLE, LEVEL)
    row = rows_of(cascade, CHOSEN[name])
    found = model.evaluate(row[None])
    gains = gains_of(cascade, row, "roll")
    crossover, step = float(found.crossover.value[0, 3]), 1e-4
    phase = np.angle(expected_loop(name, gains, np.array([crossover - step, crossover + step]), h))
    assert found.group_delay.value[0, 3] == pytest.approx(-(phase[1] - phase[0]) / (2.0 * step), rel=1e-5)
    up_to = float(found.rejection.value[0, 3])
    below = np.abs(1.0 / (1.0 + expected_loop(name, gains, np.geomspace(0.05, up_to * (1.0 - 1e-6), 400), h)))
    assert below.max(axis=0) < np.sqrt(0.5) * (1.0 + 1e-5)
    there = expected_loop(name, gains, np.array([up_to]), h)
    assert abs(1.0 / (1.0 + there[0])) == pytest.approx(np.sqrt(0.5), rel=1e-5)
