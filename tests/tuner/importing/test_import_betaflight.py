"""Betaflight's diff and dump read back: what was exported, profiles, defaults, other versions, and files that are none."""

from dataclasses import replace

import numpy as np
import pytest

from plant.errors import InputError
from tests.tuner.export.controllers import pid
from tests.tuner.export.flying_autopilots import attitude_feedback, attitude_gains, betaflight_torque, by_address
from tests.tuner.importing.reading import exported, read, same_flight, write
from tuner.export.betaflight import EXPORTER, FILE

DIFF = """
# version
# Betaflight / STM32F7X2 (S7X2) 2025.12.0 Dec  1 2025 / 12:00:00 (norevision) MSP API: 1.47

batch start
# reset configuration to default settings
defaults nosave
# master
set motor_poles = 12

profile 0

# profile 0
set p_roll = 50
set i_roll = 90
set d_roll = 30
set angle_p_gain = 60

profile 1
set p_roll = 77

rateprofile 0
# rateprofile 0
set roll_srate = 3

# restore original profile selection
profile 1
# save configuration
save
"""


@pytest.mark.parametrize(("airframe", "profile"), [("iris", 0), ("f450", 3)])
def test_an_export_comes_back_as_what_it_holds(airframe, profile, tmp_path):
    given = pid(
        airframe,
        **{f"{axis}__{name}": value for axis in "xyz" for name, value in (("kp", 2.5), ("ki", 0.6), ("kd", 2.6))},
        **{"yaw__kp": 20.0, "yaw__ki": 12.0, "yaw__kd": 6.0},
    )
    # The position loops stand at our defaults on the way back, and the heading loop is an option.
    made = exported(EXPORTER, given, f"profile={profile}")
    heading = float(max(np.roots([6.0, -20.0, 12.0]).real))
    back = read(
        "betaflight",
        write(tmp_path, made.files[FILE]),
        f"profile={profile}",
        f"heading_gain={heading!r}",
        airframe=airframe,
    )
    assert back.controller.gains == pytest.approx(made.held.gains, rel=1e-12)
    assert same_flight(back.controller, made.held) or np.allclose(
        back.controller.gains, made.held.gains, rtol=1e-12, atol=0.0
    )
    assert same_flight(replace(back.controller, gains=made.held.gains), made.held)
    assert not any("Not in the file" in note or "left out" in note or "Switches" in note for note in back.notes)


@pytest.mark.parametrize(("profile", "p_roll", "i_roll", "level"), [(0, 50, 90, 60), (1, 77, 80, 50), (2, 45, 80, 50)])
def test_a_vehicles_own_diff_flies_as_betaflight_would(profile, p_roll, i_roll, level, tmp_path):
    values = {
        "p_roll": p_roll, "i_roll": i_roll, "p_pitch": 47, "i_pitch": 84, "p_yaw": 45, "i_yaw": 80, "angle_p_gain": level,
    }  # fmt: skip
    back = read("betaflight", write(tmp_path, DIFF), f"profile={profile}", "heading_gain=3", airframe="iris")
    vehicle = back.controller.airframe.vehicle
    flown, _ = attitude_feedback(lambda a, r, i: betaflight_torque(values, vehicle, 1.0, a, r, i, 3.0), vehicle)
    assert attitude_gains(back.controller) == pytest.approx(flown, rel=1e-6)
    assert back.controller.control_period == 0.001


def test_what_was_taken_and_left_out_is_said(tmp_path):
    notes = "\n".join(read("betaflight", write(tmp_path, DIFF), airframe="iris").notes)
    for word in (
        "i_pitch = 84",
        "heading loop is 2 1/s",
        "d_roll (",
        "tpa_rate = 65",
        "simplified_pids_mode = RPY",
        "iterm_relax = RP",
    ):
        assert word in notes, word
    assert "p_roll = " not in notes


def test_derivative_counted_as_inertia(tmp_path):
    file = write(tmp_path, DIFF)
    one, other = (
        by_address(read("betaflight", file, f"rate_derivative={how}", airframe="iris").controller)
        for how in ("drop", "inertia")
    )
    slope = 7.0664 * 2.0 * np.sqrt(1.545 * 9.81 / 4.0 / 7.0664)
    share = 30 * 0.000529 * 180.0 / np.pi * 4.0 * 0.22 * slope / 1000.0 / 0.029125
    assert one["roll.kp"] / other["roll.kp"] == pytest.approx(1.0 + share, rel=1e-4)
    assert one["yaw.kp"] == other["yaw.kp"]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("set p_roll = 4.5\n", "p_roll: given '4.5'; this must be a whole number"),
        ("set p_roll = nan\n", "p_roll: given 'nan'; this must be a whole number"),
        ("set p_roll = 40\nprofile 0\nset p_roll = 41\n", "p_roll: given twice, as 40 and as 41"),
        ("set angle_level_strength = 50\n", "angle_level_strength: .* now angle_p_gain"),
        ("set pid_type = ADRC\n", "pid_type: given ADRC"),
        ("set use_integrated_yaw = ON\n", "use_integrated_yaw: given ON"),
        ("###ERROR IN set: INVALID NAME: 'p_rol'###\n", "holds the error '###ERROR"),
        ("hello\n", "holds no setting of profile 0"),
        ("set p_yaw = 0\nset i_yaw = 0\n", "yaw.kp: "),
    ],
)
def test_what_is_no_such_file_is_refused(content, words, tmp_path):
    with pytest.raises(InputError, match=f"vehicle.txt: {words}"):
        read("betaflight", write(tmp_path, content))
