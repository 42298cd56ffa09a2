"""What is said of a vehicle's dead time, gyro and frame before a study flies."""

from dataclasses import replace

import tuner
from tuner.analysis.fitted import fitted_texts


def test_a_study_tells_what_its_vehicle_is_fitted_with():
    """Rotors of the Hummingbird hover at 79 turns a second: of 250 samples a second, twice that is heard at 250 - 158 = 92 Hz."""
    system = tuner.load_study("quickstart").system
    assert fitted_texts(system) == []
    loud = system.vehicle._replace(
        dead_time=0.008, vibration_1=0.05, vibration_2=0.02, gyro_cutoff=200.0,
        mode_frequency=60.0, mode_damping=0.05, mode_gain=-0.3,
    )  # fmt: skip
    assert fitted_texts(replace(system, vehicle=loud)) == [
        "Dead time of the rotors: 8 ms, flown as two control periods of 4 ms.",
        "The gyro hears each rotor, at hover speed with 0.05 rad/s at 79 Hz and 0.02 rad/s at 158 Hz (sampled at 250 Hz it is "
        "heard at 92 Hz).",
        "The gyro has a low-pass of its own at 200 Hz; the control rate is too low for it to delay the rate.",
        "The frame has a mode at 60 Hz, damping 0.05, gain -0.3, in what the gyro hears; flights and margins have it.",
    ]


def test_it_tells_where_notches_stand_and_which_are_too_low():
    """At hover speed of 79 turns a second: below 100 Hz there is none, from 150 Hz on it is whole."""
    system = tuner.load_study("quickstart", {"controller.rpm_notches": 2}).system
    (said,) = fitted_texts(system)
    assert (
        said
        == "Notches follow the rotors; at hover speed they stand, with their share, at 79 Hz (0%) and 158 Hz (100%)."
    )
