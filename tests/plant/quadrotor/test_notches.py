"""Notches that follow the rotors, against SciPy's bilinear transform of the analogue notch and rotors that speed up."""

from typing import Any

import numpy as np
import pytest
from scipy import signal

from objectives.margins.period import NO_METERS
from plant.backends.stepping import fly_steps, unchanged
from plant.errors import InputError
from plant.law_registry import LAWS
from plant.loop import Timing
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.closed_loop import close_loop
from plant.quadrotor.features import BARE, vehicle_features
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.quadrotor.notches import weight_of
from plant.quadrotor.sensors import Measurement
from plant.vectors import Rotors, Vec3
from tests.plant.harness import HUMMINGBIRD, LIMITS, TARGETS, batch, default_gains, references, scenario

H = 0.001
QUALITY, MIN_FREQUENCY = 4.0, 30.0
STILL = Vec3(0.0, 0.0, 0.0)
TURN = 2.0 * np.pi


def behind(rate: Any, speeds: Any, harmonics: int = 3) -> Any:
    """Rates (K, 3) [rad/s] as laws hear them while rotors turn at speeds (K, 4) [rad/s]."""
    options = ControlOptions(rpm_notches=harmonics, rpm_notch_q=QUALITY, rpm_notch_min=MIN_FREQUENCY)
    know = nominal(HUMMINGBIRD, options, H)
    notches = vehicle_features(HUMMINGBIRD, H, know.harmonics).notches
    memory, out = notches.start(Rotors(*speeds[0])), []
    for each, speed in zip(rate, speeds, strict=True):
        seen = Measurement(STILL, STILL, STILL, Vec3(*each), STILL, STILL)
        m, memory = notches.follow(memory, seen, Rotors(*speed), know, H)
        out.append(m.rate)
    return np.array(out)


def sampled_notch(centre: float) -> tuple[Any, Any]:
    """Numerator and denominator of (s^2 + 1)/(s^2 + s/Q + 1) with s = 1 brought to a centre [Hz] by the bilinear transform."""
    return signal.bilinear([1.0, 0.0, 1.0], [1.0, 1.0 / QUALITY, 1.0], 0.5 / np.tan(np.pi * centre * H))


@pytest.mark.parametrize("harmonics", [1, 2, 3])
def test_at_constant_speed_they_are_notches_in_series(harmonics: int) -> None:
    """Of each rotor at each harmonic, up to 0.48 of the control rate; white noise comes out as SciPy's filters leave it."""
    turns = np.array([61.0, 70.0, 83.0, 190.0])
    rate = np.random.default_rng(5).standard_normal((300, 3))
    wanted = rate
    for n in range(1, harmonics + 1):
        for speed in turns:
            wanted = signal.lfilter(*sampled_notch(min(n * speed, 480.0)), wanted, axis=0)
    found = behind(rate, np.tile(TURN * turns, (300, 1)), harmonics)
    assert found == pytest.approx(wanted, rel=1e-9, abs=1e-9)


def test_a_line_that_moves_is_taken_out() -> None:
    """Of a rotor that goes from 60 to 120 turns a second in 2 s, under a tenth is left; a notch in the middle leaves over half."""
    speed = np.linspace(60.0, 120.0, 2000)
    line = np.sin(TURN * np.cumsum(speed) * H)
    rate = np.stack([line, line, line], axis=1)
    moving, middle = np.zeros((2, 2000, 4))
    moving[:, 1], middle[:, 1] = TURN * speed, TURN * 90.0
    left, still = (np.sqrt(np.mean(behind(rate, speeds, 1)[200:] ** 2)) for speeds in (moving, middle))
    assert left < 0.1 * np.sqrt(0.5)
    assert still > 0.5 * np.sqrt(0.5)


def test_weights_fade_out() -> None:
    """None up to the least frequency, all from half of it above on."""
    assert [weight_of(f, 100.0) for f in (50.0, 100.0, 125.0, 150.0, 400.0)] == [0.0, 0.0, 0.5, 1.0, 1.0]
    # Below 30 Hz a rotor is left as it is.
    rate = np.random.default_rng(2).standard_normal((50, 3))
    assert np.array_equal(behind(rate, np.full((50, 4), TURN * 29.0), 1), rate)


def test_without_them_nothing_is_kept() -> None:
    """The loop is the one of before, and what cannot be is refused."""
    assert vehicle_features(HUMMINGBIRD, H, nominal(HUMMINGBIRD, ControlOptions(), H).harmonics) == BARE
    with pytest.raises(InputError, match="rpm_notches: given 4; allowed: 0 to 3"):
        ControlOptions(rpm_notches=4)


def test_they_quieten_the_rotors_that_the_gyro_hears() -> None:
    """In a hover of a vehicle that vibrates, the commands of rotors jitter less than a tenth as much as without them."""
    vehicle, steps, timing = HUMMINGBIRD._replace(vibration_1=0.1, vibration_2=0.05), 700, Timing(H, H)
    calm, drawn = np.zeros((1, steps, 12)), np.zeros((1, steps, 16))
    drawn[:, :, 12:] = [0.1, 0.35, 0.62, 0.97]
    inputs = scenario(batch([vehicle], calm, drawn, references(steps)), 0)
    jitter = []
    for harmonics in (0, 2):
        know = nominal(
            vehicle, ControlOptions(rpm_notches=harmonics, rpm_notch_q=QUALITY, rpm_notch_min=MIN_FREQUENCY), H
        )
        loop = close_loop(close_cascade(LAWS["pid"], LAWS["pid"]), NO_METERS, vehicle_features(vehicle, H, harmonics))
        thrusts: list[Any] = []
        fly_steps(
            loop,
            unchanged,
            default_gains(loop),
            know,
            inputs,
            TARGETS,
            LIMITS,
            timing,
            lambda _, flight, kept=thrusts: kept.append(flight.in_force),
        )
        jitter.append(np.std(np.array(thrusts)[steps // 2 :], axis=0).max())
    assert jitter[0] > 0.001 * 0.25 * vehicle.mass * vehicle.gravity
    assert jitter[1] < 0.1 * jitter[0]
