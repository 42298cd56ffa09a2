"""Command lines in their order: repetitions, profiles, resets, and one file loaded over another."""

import pytest

from plant.errors import InputError
from tests.tuner.exchange.reading import read, write
from tests.tuner.extensions.betaflight.test_sliders import BANNER
from tuner.extensions.betaflight.commands import loaded_over, read_cli, read_profile


def notes(file) -> str:
    return "\n".join(read("betaflight", file, "loops=own", airframe="f450").notes)


def test_the_last_of_repeated_settings_counts_and_is_named(tmp_path):
    file = write(tmp_path, "set p_roll = 40\nprofile 0\nset p_roll = 41\nset i_roll = 70\nset p_roll = 42\n")
    assert read_profile(file, 0).repeated == {"p_roll": ["40", "41", "42"]}
    assert read_cli(file, 0)["p_roll"] == "42"
    assert "Set more than once; the last value counts, as on the vehicle: p_roll 40 to 42." in notes(file)


def test_a_setting_that_stays_the_same_is_no_repetition(tmp_path):
    assert "more than once" not in notes(write(tmp_path, "set p_roll = 40\nset p_roll = 40\n"))


def test_a_gain_behind_a_rate_profile_is_of_the_selected_profile(tmp_path):
    text = "profile 0\nset p_roll = 50\nrateprofile 0\nset p_pitch = 10\nprofile 1\nrateprofile 1\nset p_pitch = 20\n"
    assert read_cli(write(tmp_path, text), 0)["p_pitch"] == "10"


@pytest.mark.parametrize("line", ["SET P_Roll=51", "set p_roll = 51 # mine", "set  p_roll  =  51"])
def test_lines_are_read_as_the_firmware_reads_them(line, tmp_path):
    assert read_cli(write(tmp_path, f"{line}\n"), 0) == {"p_roll": "51"}


def test_defaults_of_a_group_reset_that_group_alone(tmp_path):
    text = "set dyn_notch_count = 1\nset rpm_filter_q = 300\nset p_roll = 40\ndefaults group_id 554 nosave # PG_DYN_NOTCH_CONFIG\n"
    assert read_cli(write(tmp_path, text), 0) == {"rpm_filter_q": "300", "p_roll": "40"}
    assert read_cli(write(tmp_path, f"{text}defaults nosave\nset i_roll = 1\n"), 0) == {"i_roll": "1"}


def test_an_empty_active_profile_is_named_with_those_that_hold_gains(tmp_path):
    file = write(tmp_path, "profile 0\nprofile 1\nset p_roll = 60\nset i_roll = 90\nprofile 0\n")
    assert (
        "Read is PID profile 0 (active), for which the file has no settings: its gains are the defaults. Other profiles: 1 (2 "
        "settings)." in notes(file)
    )


def test_profiles_are_named_with_the_active_one(tmp_path):
    file = write(tmp_path, "profile 0\nset p_roll = 60\nprofile 2\nset p_roll = 61\n")
    assert "Read is PID profile 0 (active: 2) with 1 settings; the file has the profiles 2 (1 settings), too." in notes(
        file
    )
    assert "PID profile" not in notes(write(tmp_path, "profile 0\nset p_roll = 60\nprofile 1\n", "one.txt"))


def test_sliders_of_a_vehicle_act_in_a_file_that_is_loaded_over_it(tmp_path):
    """The gain that the proposal sets by hand stays, and the vehicle's own sliders count where it sets none."""
    before = write(tmp_path, "profile 1\nset simplified_pi_gain = 200\nset p_roll = 90\n", "before.txt")
    after = write(tmp_path, "set simplified_i_gain = 50\nsimplified_tuning apply\nset p_yaw = 3\n", "after.txt")
    merged = read_profile(write(tmp_path, loaded_over(before, after), "merged.txt"), 1)
    # Twice the default P of 45, and I of 80 times 2 times a half.
    assert (merged.values["p_roll"], merged.values["i_roll"], merged.values["p_yaw"]) == ("90", "80", "3")
    assert not merged.repeated


def test_an_apply_of_the_vehicles_file_is_before_the_sliders_of_the_proposal(tmp_path):
    before = write(tmp_path, "set simplified_pi_gain = 200\nsimplified_tuning apply\n", "before.txt")
    after = write(tmp_path, "set simplified_pi_gain = 50\n", "after.txt")
    assert read_cli(write(tmp_path, loaded_over(before, after), "merged.txt"), 0)["p_roll"] == "90"


def test_a_preset_of_another_release_is_refused(tmp_path):
    before = write(tmp_path, BANNER.format("2025.12") + "profile 0\nset p_roll = 40\n", "before.txt")
    after = write(tmp_path, "#$ FIRMWARE_VERSION: 4.4\n#$ FIRMWARE_VERSION: 4.5\nset p_roll = 50\n", "after.txt")
    with pytest.raises(
        InputError, match=r"after.txt: FIRMWARE_VERSION: is a preset for Betaflight 4.4, 4.5, and .*2025.12"
    ):
        loaded_over(before, after)


def test_a_setting_of_the_vehicle_that_a_file_replaces_is_no_repetition(tmp_path):
    before = write(tmp_path, "profile 0\nset p_roll = 40\nset p_roll = 44\n", "before.txt")
    after = write(tmp_path, "set p_roll = 50\n", "after.txt")
    merged = read_profile(write(tmp_path, loaded_over(before, after), "merged.txt"), 0)
    assert (merged.values, merged.repeated) == ({"p_roll": "50"}, {})
