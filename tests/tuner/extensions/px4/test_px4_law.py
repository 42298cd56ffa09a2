"""The law against PX4's own code, sample by sample: D on the derivative of the filtered rate, with its first-order low-pass."""

from math import sin
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import signal as scipy_signal

from plant.law_registry import LAWS
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from tests.clients.px4_code import Px4Code

Array = NDArray[np.float64]
LAW = LAWS["px4"]
# scipy tells pyright less than it knows.
signal: Any = scipy_signal
NAMES = ("p", "i", "d", "ff", "i_limit", "gyro_cutoff", "d_cutoff", "notch", "notch_width")
COUNT = 1500
# Largest difference over the largest torque of a run; measured over the 80 runs of each precision: 2.7e-14 in double. PX4's own
# float32 reaches 9e-6 at 1 kHz and 2.3e-6 at 400 Hz: the derivative subtracts rates that agree in their first digits.
DOUBLE, SINGLE = 1e-12, 2e-5


def gain_set(seed: int, h: float) -> list[float]:
    """Return random gains in the ranges of the law; every second set has a notch, every fourth no filter of the gyro."""
    rng = np.random.default_rng([41, seed])
    spans = [LAW.span(gain, "roll", "attitude") for gain in LAW.gains if gain.name in NAMES[:5]]
    gains = [rng.uniform(span.low, span.high) for span in spans]
    cutoffs = [rng.uniform(20.0, 120.0) if seed % 4 else 0.0, rng.uniform(10.0, 100.0)]
    notch = [rng.uniform(40.0, min(300.0, 0.4 / h)), rng.uniform(5.0, 50.0)] if seed % 2 else [0.0, 20.0]
    return [*gains, *cutoffs, *notch]


def motion(seed: int, scale: float) -> Array:
    """Return smooth random signals (n, 2) [rad/s]: a rate and its setpoint."""
    rng = np.random.default_rng([42, seed])
    noise = rng.standard_normal((COUNT, 2))
    return scale * (np.cumsum(noise, axis=0) / np.sqrt(COUNT) + 0.05 * rng.standard_normal((COUNT, 2)))


def torque_of(h: float, gains: list[float], rates: Array, setpoints: Array, saturated: NDArray[np.intc]) -> Array:
    """Return the torque (n,) of our law, of which a unit accelerates by 1 rad/s2."""
    constants = LAW.prepare(LAW.Gains(angle_p=4.0, authority=1.0, **dict(zip(NAMES, gains, strict=True))), h)
    memory, torque = LAW.start(constants, Measured(0.0, rates[0]), 0.0), np.empty_like(rates)
    for n, (rate, setpoint) in enumerate(zip(rates, setpoints, strict=True)):
        applied = Applied(0.0, -float(saturated[n]))
        torque[n], memory = LAW.step(
            memory, constants, Channel(1.0, 0.0), Setpoint(0.0, setpoint, 0.0), Measured(0.0, rate), applied, h
        )
    return torque


@pytest.mark.parametrize(("precision", "tolerance"), [("double", DOUBLE), ("single", SINGLE)])
@pytest.mark.parametrize("h", [0.0025, 0.001])
def test_the_law_is_px4s_own_code(precision: str, tolerance: float, h: float) -> None:
    """40 sets of gains, small motions and large ones, with spells of saturation."""
    code = Px4Code(precision)
    worst = 0.0
    for seed in range(40):
        rates, setpoints = motion(seed, 20.0 if seed % 3 else 0.5).T.copy()
        saturated = np.array([(0, 1, 0, -1)[n // 90 % 4] for n in range(COUNT)], dtype=np.intc)
        gains = gain_set(seed, h)
        theirs = code.torque(1.0 / h, gains, rates, setpoints, saturated)
        ours = torque_of(h, gains, rates, setpoints, saturated)
        worst = max(worst, float(np.abs(ours - theirs).max() / np.abs(theirs).max()))
    assert worst < tolerance, worst


@pytest.mark.parametrize("h", [0.0025, 0.001])
def test_d_is_on_the_derivative_of_the_filtered_rate(h: float) -> None:
    """The D path alone: Butterworth low-pass, difference and a first-order low-pass, by scipy; needs no code of PX4."""
    gyro, d_cutoff, d = 35.0, 25.0, 0.004
    rates = motion(7, 5.0)[:, 0].copy()
    rates -= rates[0]
    b, a = signal.butter(2, gyro, fs=1.0 / h)
    filtered = signal.lfilter(b, a, rates)
    share = h / (h + 1.0 / (2.0 * np.pi * d_cutoff))
    acceleration = signal.lfilter([share], [1.0, share - 1.0], np.diff(filtered, prepend=0.0) / h)
    gains = [0.0, 0.0, d, 0.0, 1.0, gyro, d_cutoff, 0.0, 20.0]
    ours = torque_of(h, gains, rates, np.zeros(COUNT), np.zeros(COUNT, dtype=np.intc))
    np.testing.assert_allclose(ours, -d * acceleration, atol=1e-9 * np.abs(acceleration).max())


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_attitude_loop_is_px4s_for_small_errors(axis: int) -> None:
    """Its error is 2 sin(e/2): 1e-6 from our e at 5 mrad, 1.1 % at 0.52 rad."""
    code = Px4Code("double")
    rng = np.random.default_rng(43)
    for _ in range(40):
        gain, angle, error = rng.uniform(1.0, 12.0), rng.uniform(-0.4, 0.4), rng.uniform(-0.9, 0.9)
        given = code.rate_setpoint(axis, gain, angle, angle + error)
        assert given == pytest.approx(2.0 * gain * sin(0.5 * error), rel=1e-9)
        constants = LAW.prepare(
            LAW.Gains(angle_p=gain, authority=1.0, **dict(zip(NAMES, [1.0, 0, 0, 0, 1.0, 0, 0, 0, 20.0], strict=True))),
            0.0025,
        )
        small = 0.005 * error
        seen = Measured(angle, 0.0)
        memory = LAW.start(constants, seen, 0.0)
        ours, _ = LAW.step(
            memory, constants, Channel(1.0, 0.0), Setpoint(angle + small, 0.0, 0.0), seen, Applied(0.0, 0.0), 0.0025
        )
        assert ours == pytest.approx(code.rate_setpoint(axis, gain, angle, angle + small), rel=1e-6)


def test_the_yaw_rate_asked_for_is_fed_forward() -> None:
    """Level, PX4's feed-forward of yaw is the rate of our setpoint."""
    code = Px4Code("double")
    assert code.rate_setpoint(2, 2.8, 0.1, 0.103, 0.7) == pytest.approx(2.8 * 0.003 + 0.7, rel=1e-6)
