"""Presets: includes from the folder of presets or beside the file, and the options that are checked."""

import pytest

import tuner
from plant.errors import InputError
from tests.tuner.exchange.reading import read, write
from tests.tuner.extensions.autopilots.test_sources import BETAFLIGHT
from tests.tuner.extensions.judge.test_reading_once import without_flights
from tuner.extensions.autopilots.sources import guess_source, sources, version_fault
from tuner.extensions.betaflight.commands import read_cli
from tuner.extensions.betaflight.presets import MAX_DEPTH, command_lines

__all__ = ["without_flights"]
DEFAULTS = """#$ TITLE: Defaults
#$ FIRMWARE_VERSION: 4.3
set p_roll = 45
set i_roll = 80
#$ OPTION BEGIN (CHECKED): Small
set p_roll = 1
#$ OPTION END
#$ OPTION BEGIN (CHECKED): Shared
set i_pitch = 2
#$ OPTION END
"""
PRESET = """#$ TITLE: A tune
#$ FIRMWARE_VERSION: 4.4
#$ FIRMWARE_VERSION: 4.5
#$ INCLUDE: presets/4.3/tune/defaults.txt

set simplified_pi_gain = 120
#$ OPTION_GROUP BEGIN: Choices
    #$ OPTION BEGIN (CHECKED): Firm I
        set simplified_i_gain = 200
    #$ OPTION END
    #$ option begin (unchecked): Soft I
        set simplified_i_gain = 10
        #$ INCLUDE: presets/4.3/rates/defaults.txt
    #$ OPTION END
    #$ OPTION BEGIN (UNCHECKED): Shared
    #$ OPTION END
#$ OPTION_GROUP END
simplified_tuning apply
"""


@pytest.fixture
def preset(tmp_path):
    for folder in ("4.3/tune", "4.5/tune/pilot"):
        (tmp_path / "presets" / folder).mkdir(parents=True)
    write(tmp_path / "presets" / "4.3" / "tune", DEFAULTS, "defaults.txt")
    return write(tmp_path / "presets" / "4.5" / "tune" / "pilot", PRESET, "tune.txt")


def test_checked_options_apply_and_unchecked_ones_do_not(preset):
    values = read_cli(preset, 0)
    # 45 * 1.2, and 80 * 1.2 * 2; "Soft I" includes a file that is not there, which is not read.
    assert (values["p_roll"], values["i_roll"], values["simplified_i_gain"]) == ("53", "191", "200")


def test_options_of_an_included_preset_act_where_the_preset_has_them_checked(preset):
    assert "i_pitch" not in _without_apply(preset)
    preset.write_text(preset.read_text().replace("(UNCHECKED): Shared", "(CHECKED): Shared"))
    values = _without_apply(preset)
    # "Small" is no option of the preset, so a pilot cannot check it.
    assert (values["i_pitch"], values["p_roll"]) == ("2", "45")


def _without_apply(preset) -> dict[str, str]:
    preset.write_text(preset.read_text().replace("simplified_tuning apply\n", ""))
    return read_cli(preset, 0)


def test_notes_name_options_releases_and_sliders(preset):
    notes = "\n".join(read("betaflight", preset, "loops=own", airframe="f450").notes)
    assert "Options of the preset, applied: Firm I; left out: Soft I, Shared." in notes
    assert "A preset for Betaflight 4.4, 4.5, read as 4.5." in notes
    assert "'simplified_tuning apply' stores gains and cut-offs of the sliders: p_roll = 53, i_roll = 191" in notes


def test_a_preset_states_its_release(preset, tmp_path):
    kind = sources()["betaflight"]
    assert guess_source(preset) == "betaflight" and version_fault(kind, [preset]) == "" and kind.version(preset) is None
    one = write(tmp_path, "#$ FIRMWARE_VERSION: 4.5\nset p_roll = 40\n", "one.txt")
    assert kind.version(one) == "4.5"
    old = write(tmp_path, "#$ FIRMWARE_VERSION: 4.1\nset p_roll = 40\n", "old.txt")
    assert "is a preset for Betaflight 4.1; known are Betaflight 4.3" in version_fault(kind, [old])


REFUSED = "#$ FIRMWARE_VERSION: 2025.12\nset p_roll = 40\nset anti_gravity_gain = 4000\n"


def test_a_setting_that_the_firmware_refuses_leaves_the_earlier_value(tmp_path):
    """A published tune of 2025.12 has this line: the board answers it with an error, and goes on."""
    file = write(tmp_path, REFUSED)
    notes = "\n".join(read("betaflight", file, "loops=own", airframe="f450").notes)
    assert "anti_gravity_gain" not in read_cli(file, 0)
    assert (
        "The firmware refuses these settings, so the earlier values stay: anti_gravity_gain = 4000 (allowed 0 to 250)."
        in notes
    )
    # A board prints no such value, so in its answer the file is damaged or of another firmware.
    printed = write(tmp_path, BETAFLIGHT.format("2025.12", 45) + "set anti_gravity_gain = 4000\n", "printed.txt")
    with pytest.raises(InputError, match="anti_gravity_gain: given 4000; allowed 0 to 250"):
        read("betaflight", printed, "loops=own", airframe="f450")


def test_a_preset_of_unchecked_options_says_how_it_sets_something(tmp_path):
    file = write(
        tmp_path, "#$ FIRMWARE_VERSION: 4.5\n#$ OPTION BEGIN (UNCHECKED): Gains\nset p_roll = 40\n#$ OPTION END\n"
    )
    with pytest.raises(InputError, match="holds no setting of profile 0; check options of the preset, or give"):
        read_cli(file, 0)


def test_an_include_beside_the_preset_is_read(tmp_path):
    write(tmp_path, "set i_roll = 5\n", "defaults.txt")
    file = write(tmp_path, "#$ INCLUDE: presets/4.3/tune/defaults.txt\nset p_roll = 4\n")
    assert read_cli(file, 0) == {"i_roll": "5", "p_roll": "4"}


@pytest.mark.parametrize(
    "name", ["presets/none.txt", "../secret.txt", "presets/../../secret.txt", "/etc/passwd", "presets/4.3", "C:\\x.txt"]
)
def test_an_include_that_is_not_below_the_presets_is_refused(name, preset, tmp_path):
    write(tmp_path.parent, "set p_roll = 3\n", "secret.txt")
    preset.write_text(f"#$ INCLUDE: {name}\nset p_roll = 4\n")
    with pytest.raises(
        InputError, match=r"tune.txt: INCLUDE: includes .*neither in its folder nor in the folder of all presets"
    ) as caught:
        command_lines(preset)
    assert "\n" not in str(caught.value)


def test_an_include_by_a_link_out_of_the_presets_is_refused(preset, tmp_path):
    (tmp_path / "presets" / "link.txt").symlink_to(write(tmp_path.parent, "set p_roll = 3\n", "secret.txt"))
    preset.write_text("#$ INCLUDE: presets/link.txt\n")
    with pytest.raises(InputError, match="neither in its folder nor in the folder of all presets"):
        command_lines(preset)


@pytest.mark.parametrize("times", [1, 2, MAX_DEPTH])
def test_presets_that_include_each_other_are_refused(times, preset):
    preset.write_text("#$ INCLUDE: presets/4.5/tune/pilot/tune.txt\n" * times)
    with pytest.raises(InputError, match="includes more than"):
        command_lines(preset)


def test_lines_without_end_are_refused(preset, tmp_path):
    write(tmp_path / "presets" / "4.3" / "tune", "set p_roll = 1\n" * 30_000, "defaults.txt")
    preset.write_text("#$ INCLUDE: presets/4.3/tune/defaults.txt\n" * 4)
    with pytest.raises(InputError, match="more than 100,000 lines"):
        command_lines(preset)


def test_resolved_lines_stay_as_they_are(preset, tmp_path):
    lines = command_lines(preset)
    assert command_lines(write(tmp_path, "\n".join(lines), "again.txt")) == lines


def test_a_preset_is_judged_over_the_vehicles_file(preset, tmp_path, without_flights):
    before = write(tmp_path, BETAFLIGHT.format("4.5", 45), "before.txt")
    with pytest.raises(InputError, match="the flights were reached"):
        tuner.judge(preset, before)
    newer = write(tmp_path, BETAFLIGHT.format("2026.6", 45), "newer.txt")
    with pytest.raises(InputError, match=r"tune.txt: FIRMWARE_VERSION: is a preset for Betaflight 4.4, 4.5"):
        tuner.judge(preset, newer)


def test_the_rollback_of_a_preset_holds_what_it_includes(preset, tmp_path):
    """A command line knows no INCLUDE."""
    after = write(tmp_path, "set profile_name = x\n", "after.txt")
    opinion = tuner.judge(after, preset, out=tmp_path / "out")
    assert opinion.verdict == "not judged" and opinion.folder is not None and opinion.document.rollback is not None
    rollback = (opinion.folder / opinion.document.rollback).read_text()
    assert "set p_roll = 45\n" in rollback and "INCLUDE" not in rollback
