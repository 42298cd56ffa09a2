"""Lines of the rotors out of logs that the plant's own gyro made, and none out of logs that have none."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from scipy import signal

from plant.backends.array import rebinder
from plant.laws.filters import Section
from plant.quadrotor.airframes import load
from plant.quadrotor.airframes.rules import hover_speed
from plant.quadrotor.gyro import GyroPath, Lines, all_lines
from plant.vectors import Rotors
from tuner.extensions.identification.identify import Identified
from tuner.extensions.identification.onward import identified_text, identified_values
from tuner.extensions.identification.rotor_lines import rotor_lines
from tuner.extensions.vehicle_fit.parameters import low_pass_delay

PRIOR = load("crazyflie-pybullet")
FASTER = 1.2
"""Speed of the rotors over that of the model."""
AMPLITUDES = (0.03, 0.012, 0.02)


def lfilter(b: ArrayLike, a: ArrayLike, series: ArrayLike) -> NDArray[np.float64]:
    """The series (n, k) through b/a, from rest."""
    return np.asarray(signal.lfilter(b, a, series, axis=0), dtype=float)


def made(identified: Identified, rate: float, amplitudes: tuple[float, float, float]) -> Identified:
    """The same fit with a log of 15 s: commands that wander, slow motion, white noise, and lines behind the gyro's low-pass."""
    numbers, vehicle = identified.space.numbers(identified.fit.estimate), identified.airframe.vehicle
    draw, count = np.random.default_rng(4), round(15.0 * rate)
    time, hover = np.arange(count) / rate, hover_speed(vehicle)
    wander = lfilter([1.0 / rate], [1.0, 1.0 / rate - 1.0], 3.0 * draw.standard_normal((count, 4)))
    command = 0.652 + 0.05 * wander / wander.std(axis=0)
    wanted = np.sqrt(np.polyval(numbers.curve[::-1], command) / (0.25 * vehicle.mass * vehicle.gravity))
    share = 1.0 - np.exp(-2.0 / (rate * (numbers.lag_up + numbers.lag_down)))
    ratio = 1.0 + lfilter([share], [1.0, share - 1.0], wanted - 1.0)
    speed = FASTER * hover * ratio
    turned = np.cumsum(speed, axis=0) / (2.0 * np.pi * rate) + draw.uniform(size=4)
    path = GyroPath(
        Lines(*[a / (FASTER * hover) ** 2 for a in amplitudes]),
        0.5 / (np.pi * low_pass_delay(numbers.gyro_delay)),
        Section(1.0, 0.0, 0.0, 0.0, 0.0),
        Section(1.0, 0.0, 0.0, 0.0, 0.0),
    )
    lines = rebinder()(all_lines)(Rotors(*turned.T), Rotors(*speed.T), vehicle, path)
    pole = np.exp(-60.0 / rate)
    motion = lfilter([1.0], np.poly([pole, pole]), draw.standard_normal((count, 3)))
    motion *= 0.3 / motion.std(axis=0)
    gyro = np.column_stack(lines) + motion + 1e-4 * draw.standard_normal((count, 3))
    log = replace(identified.logs[0], time=time, gyro=gyro, acceleration=np.zeros((count, 3)), command=command)
    return replace(identified, logs=(log,))


def test_lines_of_the_plants_gyro_are_found(crazyflie: Identified) -> None:
    """At 1, 2 and 3 times the speed, which is a fifth above the model's; each within a tenth of its amplitude."""
    found = rotor_lines(made(crazyflie, 4000.0, AMPLITUDES))
    hover = FASTER * hover_speed(PRIOR.vehicle) / (2.0 * np.pi)
    assert [line.harmonic for line in found] == [1, 2, 3]
    assert [line.frequency for line in found] == pytest.approx([hover, 2.0 * hover, 3.0 * hover], rel=0.02)
    assert [line.amplitude for line in found] == pytest.approx(AMPLITUDES, rel=0.1)


def test_a_log_shows_the_lines_below_its_rate_over_2_6(crazyflie: Identified) -> None:
    """The first stands at 290 Hz: 1000 Hz show it alone, 700 Hz nothing."""
    assert [line.harmonic for line in rotor_lines(made(crazyflie, 1000.0, AMPLITUDES))] == [1]
    assert rotor_lines(made(crazyflie, 700.0, AMPLITUDES)) == ()


def test_a_log_without_lines_has_none(crazyflie: Identified, tmp_path: Path) -> None:
    silent = made(crazyflie, 4000.0, (0.0, 0.0, 0.0))
    assert rotor_lines(silent) == ()
    assert not any(name.startswith("vibration") for name in identified_values(silent, ()))
    (tmp_path / "mine.toml").write_text(identified_text(silent, "A Crazyflie"), encoding="utf-8")
    assert load(tmp_path / "mine.toml").vehicle.vibration_1 == 0.0


def test_a_crazyflie_has_the_line_that_others_see(crazyflie: Identified, tmp_path: Path) -> None:
    """At 290 Hz, 1.2 mrad/s behind its low-pass; the file holds it as before that."""
    (line,) = rotor_lines(crazyflie)
    assert line.frequency == pytest.approx(290.0, rel=0.04)
    assert line.logged == pytest.approx(0.0012, rel=0.1)
    (tmp_path / "mine.toml").write_text(identified_text(crazyflie, "A Crazyflie"), encoding="utf-8")
    read = load(tmp_path / "mine.toml")
    assert read.vehicle.vibration_1 == pytest.approx(line.amplitude, rel=1e-4)
    assert "as logged; before the gyro" in read.sources["vibration_1"].source
