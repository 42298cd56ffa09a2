"""Sentences on a vehicle's dead time, gyro and frame before a study flies."""

from dataclasses import replace

import numpy as np
import pytest

import tuner
from plant.errors import InputError
from plant.quadrotor.airframes import load
from plant.quadrotor.nominal import ControlOptions, nominal
from tuner.study.fitted import fitted_texts


def test_a_study_tells_what_its_vehicle_is_fitted_with():
    """Rotors of the Hummingbird hover at 79 turns a second: of 250 samples a second, twice that is heard at 250 - 158 = 92 Hz."""
    system = tuner.load_study("quickstart", kind=tuner.Study).system
    assert fitted_texts(system) == []
    loud = system.vehicle._replace(
        dead_time=0.008,
        thrust_linear=0.4,
        vibration_1=0.05,
        vibration_2=0.02,
        gyro_cutoff=200.0,
        mode_frequency=60.0,
        mode_damping=0.05,
        mode_gain=-0.3,
    )
    share = 0.25 * loud.mass * loud.gravity / (loud.thrust_coefficient * loud.speed_max**2)
    hover = max(np.roots([0.6, 0.4, -share]))
    assert fitted_texts(replace(system, vehicle=loud)) == [
        "Dead time of the rotors: 8 ms, flown as two control periods of 4 ms.",
        f"0.4 of the full thrust is linear in the motor command; hover takes {hover:.3g} of full command. The controller inverts that "
        "curve.",
        "The gyro signal has a line of each rotor, at hover speed with 0.05 rad/s at 79 Hz and 0.02 rad/s at 158 Hz (sampled at 250 Hz it is "
        "heard at 92 Hz).",
        "The gyro has a low-pass of its own at 200 Hz; the control rate is too low for it to delay the rate.",
        "The frame has a mode at 60 Hz, damping 0.05, gain -0.3, in the gyro signal; flights and margins have it.",
    ]


def test_it_tells_where_notches_stand_and_which_are_too_low():
    """At hover speed of 79 turns a second: below 100 Hz there is none, from 150 Hz on it is whole."""
    system = tuner.load_study("quickstart", {"controller.rpm_notches": 2}, kind=tuner.Study).system
    (said,) = fitted_texts(system)
    assert (
        said
        == "Notches follow the rotors; at hover speed they stand, with their share, at 79 Hz (0%) and 158 Hz (100%)."
    )


def test_it_tells_what_is_left_of_the_thrust():
    """90 W at 0.06 ohm: 12.6 V at rest are 12.16 V under load, 11.03 V are 10.51 V, and the square of their ratio is 75 %."""
    system = tuner.load_study("quickstart", kind=tuner.Study).system
    worn = system.vehicle._replace(
        battery_full=12.6,
        battery_empty=10.5,
        battery_resistance=0.06,
        battery_capacity=7200.0,
        battery_used=5400.0,
        hover_power=90.0,
    )
    known = nominal(worn, ControlOptions(battery_compensation=0.5), system.timing.control_period)
    assert fitted_texts(replace(system, vehicle=worn, nominal=known)) == [
        "The battery gives 10.5 V in hover when a flight begins, 12.2 V when it is full: 75% of a command's thrust, of which 50% "
        "is made good."
    ]


def test_a_study_whose_rate_is_too_low_for_the_frame_is_refused(tmp_path):
    """When it is read, at its airframe: 110 Hz are more than 0.4 of 250 Hz."""
    numbers = {"frequency": (110, "Hz"), "damping": (0.05, "1"), "gain": (-0.3, "1")}
    lines = [f'mode_{k} = {{ value = {v}, unit = "{unit}", source = "a test" }}\n' for k, (v, unit) in numbers.items()]
    text = load("hummingbird").path.read_text(encoding="utf-8")
    file = tmp_path / "soft.toml"
    file.write_text(text.replace("[inertia]", "".join(lines) + "\n[inertia]", 1), encoding="utf-8")
    with pytest.raises(InputError, match="airframe.mode_frequency: given 110 Hz with a control period of 0.004 s"):
        tuner.load_study("quickstart", {"airframe": {"file": str(file)}})
