"""Betaflight's diff and dump read back: what was exported, profiles, defaults, other versions, and files that are none."""

from dataclasses import replace

import numpy as np
import pytest

from plant.errors import InputError
from tests.tuner.exchange.controllers import pid
from tests.tuner.exchange.flying_autopilots import attitude_feedback, attitude_gains, betaflight_torque, by_address
from tests.tuner.exchange.reading import exported, read, same_flight, write
from tuner.exchange.registry import settings_of
from tuner.exchange.target import Request
from tuner.extensions.betaflight.export import FILE, TARGET

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
    made = exported(TARGET, given, f"profile={profile}")
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
        "p_roll": p_roll,
        "i_roll": i_roll,
        "p_pitch": 47,
        "i_pitch": 84,
        "p_yaw": 45,
        "i_yaw": 80,
        "angle_p_gain": level,
    }
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
        "Read as Betaflight 2025.12",
        "iterm_relax = RP",
    ):
        assert word in notes, word
    assert "p_roll = " not in notes


OLDER = """
# version
# Betaflight / STM32F7X2 (S7X2) VERSION Nov 14 2024 / 12:00:00 (0123abc) MSP API: 1.46
mixer QUADX
set yaw_motors_reversed = ON
set gyro_lpf2_static_hz = 750
profile 0
set p_roll = 50
set d_roll = 38
set iterm_limit = 300
"""


@pytest.mark.parametrize(
    ("version", "limit", "words"),
    [
        ("4.5.0", 60.0, ("Read as Betaflight 4.5,", "d_min_pitch = 34", "angle_feedforward = 50", "angle_p_gain = 50")),
        (
            "4.4.3",
            55.0,
            ("Read as Betaflight 4.4,", "d_min_pitch = 34", "angle_level_strength = 50", "level_limit = 55"),
        ),
        ("4.3.1", 55.0, ("Read as Betaflight 4.3,", "anti_gravity_gain = 3500")),
    ],
)
def test_an_older_version_is_read_with_its_own_names_and_defaults(version, limit, words, tmp_path):
    back = read("betaflight", write(tmp_path, OLDER.replace("VERSION", version)), airframe="iris")
    notes = "\n".join(back.notes)
    for word in (*words, "d_roll (", "yaw_motors_reversed = ON", "iterm_limit = 300", "gyro_lpf2_static_hz = 750"):
        assert word in notes, word
    assert "2025.12" not in notes and "iterm_windup" not in notes
    assert np.degrees(back.controller.options.tilt_limit) == pytest.approx(limit, abs=1e-9)


def test_before_2025_12_d_min_is_the_gain_that_acts_at_rest(tmp_path):
    """d_min of 0, or above d, is off: then d acts. The share of the inertia that it adds tells which one was taken."""

    def share(text):
        file = write(tmp_path, OLDER.replace("VERSION", "4.5.2").replace("set d_roll = 38", text))
        (note,) = [note for note in read("betaflight", file, airframe="iris").notes if "d_roll (" in note]
        return float(note.split("d_roll (")[1].split(" %")[0])

    low = share("set d_roll = 38\nset d_min_roll = 19")
    for text, factor in (("set d_min_roll = 0\nset d_roll = 38", 2.0), ("set d_roll = 38\nset d_min_roll = 60", 2.0)):
        assert share(text) == pytest.approx(factor * low, rel=2e-2)
    assert share("set d_roll = 38") == pytest.approx(30.0 / 19.0 * low, rel=2e-2)


def test_a_file_that_does_not_say_its_version_is_said_to_be_read_as_the_usual_one(tmp_path):
    notes = "\n".join(read("betaflight", write(tmp_path, "set p_roll = 40\n"), airframe="iris").notes)
    assert "does not say by which version" in notes and "Betaflight 2025.12" in notes
    assert "does not say" not in "\n".join(read("betaflight", write(tmp_path, DIFF), airframe="iris").notes)


@pytest.mark.parametrize(("spin", "told"), [("OFF", False), ("ON", True)])
def test_rotors_that_turn_against_the_airframes_are_said(spin, told, tmp_path):
    airframe = "iris"
    notes = read(
        "betaflight", write(tmp_path, f"set p_roll = 40\nset yaw_motors_reversed = {spin}\n"), airframe=airframe
    ).notes
    ours = pid(airframe).airframe.vehicle.spin[0] > 0.0
    assert any("against that of the airframe" in note for note in notes) == (told == ours)


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
        ("set p_pitch = 580\n", "p_pitch: given 580; allowed 0 to 250"),
        ("set dterm_lpf1_static_hz = -1\n", "dterm_lpf1_static_hz: given -1; allowed 0 to 1000"),
        ("set p_roll = nan\n", "p_roll: given 'nan'; this must be a whole number"),
        ("set angle_level_strength = 50\n", "angle_level_strength: .* now angle_p_gain"),
        ("set pid_type = ADRC\n", "pid_type: given ADRC"),
        ("set use_integrated_yaw = ON\n", "use_integrated_yaw: given ON"),
        ("mixer Y6\nset p_roll = 4\n", "mixer: given Y6; only QUADX and QUADP"),
        (
            "# Betaflight / X (Y) 3.5.7 Jun 1 2019 / 1:2:3 (a) MSP API: 1.40\nset p_roll = 4\n",
            "version: was printed by Betaflight 3.5",
        ),
        (
            "# INAV / X 7.1.0 Jun 1 2024 / 1:2:3 (a)\nset p_roll = 4\n",
            "version: INAV 7.1 is not supported",
        ),
        (
            DIFF.replace("set i_roll = 90", "set level_limit = 50"),
            "level_limit: .* now angle_limit, and the file is of 2025.12",
        ),
        ("###ERROR IN set: INVALID NAME: 'p_rol'###\n", "holds the error '###ERROR"),
        ("hello\n", "holds no setting of profile 0"),
        ("set p_yaw = 0\nset i_yaw = 0\n", "yaw.kp: "),
    ],
)
def test_what_is_no_such_file_is_refused(content, words, tmp_path):
    with pytest.raises(InputError, match=f"vehicle.txt: {words}"):
        read("betaflight", write(tmp_path, content))


def _dump(seed: int) -> str:
    """Return a file in the shape of public dumps, its two rate profiles different; by seed: release, line ends, kind of file."""
    rng = np.random.default_rng([44, seed])
    release = ("4.3.2", "4.4.3", "4.5.1", "2025.12.1", "2026.6.2")[seed % 5]
    old = release.startswith("4.")
    rates = (
        "roll_rc_rate",
        "pitch_rc_rate",
        "yaw_rc_rate",
        "roll_expo",
        "pitch_expo",
        "yaw_expo",
        "roll_srate",
        "thr_mid",
    )
    count = 6 if old else 4
    lines = [
        ("# diff all", "# dump all")[seed % 2],
        "# version",
        f"# Betaflight / STM32F7X2 (S7X2) {release} Jan  5 2026 / 19:08:42 (a4b6db1e7) MSP API: 1.46",
        *(("batch start", "defaults nosave") if seed % 3 else ()),
        "mixer QUADX",
        "# master",
        "set dshot_bidir = ON",
        "profile 0",
        "# profile 0",
        "set p_roll = 51",
        "set i_roll = 88",
        "profile 1",
        "set p_roll = 60",
        "# restore original profile selection",
        "profile 0",
    ]
    for number in range(count):
        lines += [f"rateprofile {number}", f"# rateprofile {number}", f"set rateprofile_name = R{number}"]
        lines += [f"set {name} = {rng.integers(1, 200)}" for name in rates[: int(rng.integers(2, 9))]]
        lines += [f"set rates_type = {('ACTUAL', 'BETAFLIGHT')[number % 2]}"]
    lines += ["# restore original rateprofile selection", f"rateprofile {int(rng.integers(0, count))}"]
    if release.startswith("2026"):
        lines += [
            "battery_profile 0",
            "set vbat_max_cell_voltage = 430",
            "battery_profile 1",
            "set vbat_max_cell_voltage = 435",
        ]
    return ("\n", "\r\n")[seed % 4 == 3].join([*lines, "# save configuration", "save", ""])


@pytest.mark.parametrize("seed", range(20))
def test_files_with_rate_profiles_that_differ_are_read(seed, tmp_path):
    file = write(tmp_path, _dump(seed))
    back = read("betaflight", file, airframe="iris")
    values = {"p_roll": 51, "i_roll": 88, "p_pitch": 47, "i_pitch": 84, "p_yaw": 45, "i_yaw": 80, "angle_p_gain": 50}
    flown, _ = attitude_feedback(
        lambda a, r, i: betaflight_torque(values, back.controller.airframe.vehicle, 1.0, a, r, i, 2.0),
        back.controller.airframe.vehicle,
    )
    assert attitude_gains(back.controller)[0] == pytest.approx(flown[0], rel=1e-6)


@pytest.mark.parametrize("seed", [3, 4, 8])
def test_files_with_rate_profiles_that_differ_are_taken_as_previous(seed, tmp_path):
    file = write(tmp_path, _dump(seed))
    made = TARGET.export(Request(pid("iris"), "ab" * 32, settings_of(TARGET, ()), file))
    assert "set p_roll = 51" in made.rollback[FILE].decode()


OWN = """# Betaflight / STM32F7X2 (S7X2) 2025.12.1 Dec 20 2025 / 18:22:02 (77d01ba3b) MSP API: 1.47
set gyro_lpf1_static_hz = 0
set dyn_notch_count = 2
set dterm_lpf1_static_hz = 80
set motor_pwm_protocol = DSHOT600
set failsafe_delay = 15
profile 0
set p_pitch = 58
set f_pitch = 110
set dee_roll = 40
set d_max_roll = 48
"""


def test_own_loops_name_what_they_leave_out(tmp_path):
    back = read("betaflight", write(tmp_path, OWN), "loops=own", airframe="racer5")
    notes = "\n".join(back.notes)
    for words in (
        "an export switches them off: d_max_roll = 48, f_roll = 120, d_max_pitch = 46, f_pitch = 110",
        "an export leaves: dyn_notch_count = 2.",
        "dterm_lpf1_static_hz = 80 does not act where dterm_lpf1_dyn_min_hz is above 0, and that is 75 Hz (default)",
        "gyro_lpf1_static_hz = 0 does not act where gyro_lpf1_dyn_min_hz is above 0, and that is 250 Hz (default)",
        "motor_pwm_protocol = DSHOT600, failsafe_delay = 15, dee_roll = 40",
        "Not in the file, so at the default of Betaflight 2025.12: p_roll = 45",
    ):
        assert words in notes, words
    assert by_address(back.controller)["roll.d_lpf1"] == 75.0


@pytest.mark.parametrize("loops", ["own", "pid"])
def test_a_file_is_recorded_and_its_other_settings_are_listed(loops, tmp_path):
    back = read("betaflight", write(tmp_path, OWN), f"loops={loops}", airframe="racer5")
    assert back.untouched == ("motor_pwm_protocol", "failsafe_delay", "dee_roll")
    record = back.controller.vehicle
    assert record is not None and record.target_version == "Betaflight 2025.12"
    assert record.parameters["f_pitch"] == 110.0 and "failsafe_delay" not in record.parameters
    assert "dyn_notch_count" in record.untuned and "p_pitch" not in record.untuned


def test_a_low_pass_that_does_not_follow_the_throttle_acts_as_it_is(tmp_path):
    file = write(tmp_path, OWN.replace("set dyn_notch", "set dterm_lpf1_dyn_min_hz = 0\nset dyn_notch"))
    back = read("betaflight", file, "loops=own", airframe="racer5")
    assert by_address(back.controller)["roll.d_lpf1"] == 80.0
    assert "dterm_lpf1_static_hz = 80 does not act" not in "\n".join(back.notes)


@pytest.mark.parametrize(("loops", "is_previous"), [("own", True), ("own", False), ("pid", True)])
def test_an_export_compares_with_the_vehicle(loops, is_previous, tmp_path):
    file = write(tmp_path, OWN)
    given = read("betaflight", file, f"loops={loops}", "heading_gain=3", airframe="racer5").controller
    request = Request(given, "ab" * 32, settings_of(TARGET, ()), file if is_previous else None)
    before = {one.name: one.before for one in TARGET.export(request).parameters}
    assert (before["p_pitch"], before["p_roll"]) == (58.0, None)
    assert before.get("d_max_roll", 48.0) == 48.0
