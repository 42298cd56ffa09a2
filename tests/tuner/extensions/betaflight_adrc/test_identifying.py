"""Plants out of logs of simulated loops: intervals hold the truth, and slow sticks are refused."""

import numpy as np
import pytest

import tuner
from plant.errors import InputError
from tests.tuner.extensions.betaflight_adrc.flown_logs import chirp, fly, slow_sticks
from tuner.extensions.betaflight_adrc import identifying
from tuner.extensions.betaflight_adrc.identifying import identify_axes, identify_axis
from tuner.extensions.betaflight_adrc.linear_loop import AxisPlant, Sampling
from tuner.extensions.betaflight_adrc.settings import AXES, default_tune

SAMPLING = Sampling(500e-6, 500e-6, (500.0,))
PLANTS = {"roll": AxisPlant(135.0, 0.021, 0.002), "yaw": AxisPlant(13.2, 0.0256, 0.0025, 0.13)}
TUNE = default_tune().with_numbers({"adrc_b0_roll": 6430.0, "adrc_b0_yaw": 2600.0, "adrc_gyro_lpf_hz": 0.0})
DURATION = 9.0


@pytest.fixture(scope="module")
def chirped():
    setpoint = chirp(SAMPLING.period, DURATION, 120.0)
    return fly(TUNE, PLANTS, SAMPLING, np.column_stack([setpoint] * 3), np.random.default_rng(3))


@pytest.mark.parametrize("axis", ["roll", "yaw"])
def test_a_chirp_shows_the_plant(chirped, axis):
    """Within three half-widths, so that a right interval fails one time in a million."""
    fit, plant = identify_axis(chirped, axis, SAMPLING), PLANTS[axis]
    assert fit.reason == "" and fit.excited > 30.0
    assert ("zero" in fit.intervals) == (axis == "yaw")
    for name, (low, high) in fit.intervals.items():
        truth = getattr(plant, name)
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        assert abs(truth - middle) < 3.0 * half and half < 0.2 * truth
    assert axis == "roll" or fit.plant.zero == pytest.approx(0.13, rel=0.15)


def test_a_turned_yaw_motor_changes_nothing_but_its_sense(chirped):
    turned = identifying.FlightLog(
        *("turned", "simulated", "0" * 64), chirped.time, chirped.gyro, chirped.acceleration,
        0.7 - chirped.command, setpoint=chirped.setpoint,
    )  # fmt: skip
    gains = [identify_axis(log, "yaw", SAMPLING).plant.gain for log in (chirped, turned)]
    assert gains[1] == pytest.approx(gains[0], rel=1e-3)


def test_slow_sticks_leave_the_lag_open():
    rng = np.random.default_rng(5)
    setpoint = slow_sticks(SAMPLING.period, DURATION, 150.0, rng)
    log = fly(TUNE, {"roll": PLANTS["roll"]}, SAMPLING, np.column_stack([setpoint] * 3), rng)
    assert "is not identified" in identify_axis(log, "roll", SAMPLING).reason


def test_a_still_axis_is_refused(chirped):
    assert "pitch: the acceleration gain is not identified" in identify_axis(chirped, "pitch", SAMPLING).reason


def test_logs_that_show_nothing_are_refused(monkeypatch, tmp_path, chirped):
    monkeypatch.setattr(identifying, "read_log", lambda path: chirped.between(0.0, 4.0))
    with pytest.raises(InputError, match="holds 4.0 s at 1000 Hz; give a log of 8 s or more at 400 Hz or more"):
        identify_axes(tmp_path / "log.bbl", SAMPLING)


def test_the_command_takes_a_log_and_names_what_it_does_not_show(monkeypatch, tmp_path, chirped):
    """Roll and yaw from the log, with intervals in the remarks; pitch, which stands still, by b0: no limit."""
    monkeypatch.setattr(identifying, "read_log", lambda path: chirped)
    file = tmp_path / "diff.txt"
    lines = [
        "profile 0",
        "set pid_type = ADRC",
        "set gyro_lpf1_dyn_min_hz = 0",
        "set gyro_lpf1_static_hz = 0",
        "set motor_idle = 0",
    ]
    numbers = [
        f"set {name} = {value:.0f}"
        for name, value in TUNE.numbers.items()
        if name.startswith("adrc_b0_") and name[8:] in AXES
    ]
    file.write_text("\n".join([*lines, "set adrc_gyro_lpf_hz = 0", *numbers]) + "\n")
    made = tuner.adrc(file, log=tmp_path / "chirp.bbl", gyro_rate=2000.0)
    sources = {row.axis: row.source for row in made.document.plants}
    assert sources == {"roll": "log", "pitch": "b0", "yaw": "log"} and not made.document.is_limit
    assert any("pitch: the acceleration gain" in note and "scaled by b0" in note for note in made.document.notes)
    assert "# Betaflight ADRC, build b11" in made.lines and "log chirp.bbl: b0 of roll" in made.lines
    with pytest.raises(InputError, match="--log: cannot be combined with --plant"):
        tuner.adrc(file, log=tmp_path / "chirp.bbl", plants=tmp_path / "plants.toml")


def test_slow_sticks_are_refused_on_yaw_whose_gain_they_seem_to_show(monkeypatch, vehicle, tmp_path):
    """Of 54 such fits 7 in 10 had the dead time in its interval."""
    rng = np.random.default_rng(1000)
    setpoint = slow_sticks(SAMPLING.period, DURATION, 150.0, rng)
    log = fly(TUNE, {"yaw": PLANTS["yaw"]}, SAMPLING, np.column_stack([setpoint] * 3), rng)
    assert identify_axis(log, "yaw", SAMPLING).reason == ""
    monkeypatch.setattr(identifying, "read_log", lambda path: log)
    document = tuner.adrc(
        vehicle(adrc_wc_yaw="40", adrc_wo_yaw="60"), log=tmp_path / "log.bbl", gyro_rate=2000.0
    ).document
    assert any("yaw: the log moves the output up to" in note and "fly a chirp" in note for note in document.notes)
    assert {row.source for row in document.plants} == {"b0"}


@pytest.mark.slow
def test_intervals_of_chirped_logs_hold_the_truth():
    """Of 12 logs of two axes: a share of 0.95 gives fewer than 19 of 24 in one of 1,000 tries."""
    held: dict[str, list[bool]] = {"gain": [], "lag": [], "b0": []}
    setpoint = chirp(SAMPLING.period, DURATION, 100.0)
    for seed in range(12):
        log = fly(TUNE, PLANTS, SAMPLING, np.column_stack([setpoint] * 3), np.random.default_rng(seed), 1 + seed % 2)
        for axis, plant in PLANTS.items():
            fit = identify_axis(log, axis, SAMPLING)
            for name, values in held.items():
                low, high = fit.intervals[name]
                values.append(low <= getattr(plant, name) <= high)
    assert all(sum(values) >= 19 for values in held.values()), {name: sum(values) for name, values in held.items()}
