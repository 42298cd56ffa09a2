"""Verdicts without a basis: each setting of the configuration by itself, files without rate gains, versions, other firmwares."""

import numpy as np
import pytest

import tuner
from tests.tuner.exchange.reading import write
from tuner.documents.assessment import EXIT_CODES, REFUSED, VERDICTS, AssessmentDocument
from tuner.extensions.judge import assessing
from tuner.extensions.judge.configuration import SETTINGS

HEAD = "# Betaflight / STM32F7X2 (S7X2) {}.0 Jul  1 2026 / 00:00:00 (abc) MSP API: 1.48\n"
BETAFLIGHT = HEAD.format("2026.6") + "mixer QUADX\nprofile 0\nset p_roll = 45\nset i_roll = 80\nset d_roll = 30\n"
PX4 = "# Stack: PX4 Pro\n# Version: {}\n1\t1\tMC_ROLLRATE_P\t0.15\t9\n1\t1\tMC_PITCHRATE_P\t0.15\t9\n"
ARDUPILOT = "# ArduCopter V{}\nATC_RAT_RLL_P,0.135\nATC_RAT_PIT_P,0.135\n"
CRAZYFLIE = "type: persistent_param_state\nversion: '1'\nparams:\n"
STORED = "  {}: {{is_stored: true, default_value: 0, stored_value: {}}}\n"
FILES = {
    "px4": PX4.format("1.16.0"),
    "ardupilot": ARDUPILOT.format("4.6.1"),
    "betaflight": BETAFLIGHT,
    "crazyflie": CRAZYFLIE + STORED.format("pid_rate.roll_kp", "250.0"),
}
LINES = {
    "px4": "1\t1\t{}\t{}\t6\n",
    "ardupilot": "{},{}\n",
    "betaflight": "set {} = {}\n",
    "crazyflie": STORED,
}
COMMANDS = {
    "mixer": ("mixer QUADX\n", "mixer QUADP\n"),
    "map": ("map AETR1234\n", "map TAER1234\n"),
    "mmix_#": ("mmix 0 1.0 -1.0 1.0 -1.0\n", "mmix 0 1.0 1.0 1.0 -1.0\n"),
    "resource_MOTOR_#": ("resource MOTOR 1 B00\n", "resource MOTOR 1 B01\n"),
    "feature_3D": ("feature -3D\n", "feature 3D\n"),
}
"""Settings of Betaflight that have commands of their own -> lines of two values."""
SHOWN = {"mmix_#": "mmix 0", "resource_MOTOR_#": "resource MOTOR 1", "feature_3D": "feature 3D"}
READABLE = {"FRAME_CLASS": (0, 1), "CA_ROTOR_COUNT": (0, 4), "FRAME": (1, 2), "CC_TYPE": (0, 1)}
"""Settings with values of other frames, which are refused as bad input -> two values of a quadrotor."""
WORDS = {"OFF": "ON", "LEGACY": "LINEAR", "0,1,2,3,4,5,6,7": "1,0,2,3,4,5,6,7"}
EACH = [(row, name) for row in SETTINGS for name in row.names.split() if name != "CA_AIRFRAME"]


def lines(row, name):
    """Lines of a file that set a setting to two values."""
    if name in COMMANDS:
        return COMMANDS[name]
    if name in READABLE:
        values = READABLE[name]
    elif row.harmless is not None:
        values = row.default, f"{10.0 * row.harmless[1]:g}"
    elif str(row.default) in WORDS:
        values = row.default, WORDS[str(row.default)]
    else:
        usual = 1.0 if row.default is None else float(row.default)
        values = tuple(f"{value:g}" for value in (usual, usual + 1.0))
    return [LINES[row.firmware].format(name.replace("#", "1"), value) for value in values]


def judged(folder, after, before=None, **options):
    files = [write(folder, text, name) for text, name in ((after, "after"), (before, "before")) if text is not None]
    return tuner.judge(*files, flights=2, **options)


@pytest.mark.parametrize(("row", "name"), EACH, ids=[f"{row.firmware}-{name}" for row, name in EACH])
def test_a_setting_that_changes_alone_is_not_judged(row, name, tmp_path):
    present, proposed = lines(row, name)
    opinion = judged(tmp_path, FILES[row.firmware] + proposed, FILES[row.firmware] + present)
    document = opinion.document
    assert opinion.verdict == "not judged" and not opinion.passed and EXIT_CODES[opinion.verdict] == 3
    assert document.flights == 0 and not document.loops and not document.metrics and document.lost_after is None
    assert row.decides in document.sentence and (SHOWN.get(name) or name.replace("#", "1")) in document.sentence


def test_a_frame_of_another_kind_is_bad_input(tmp_path):
    with pytest.raises(tuner.InputError, match="fixed wing"):
        judged(tmp_path, FILES["px4"] + LINES["px4"].format("CA_AIRFRAME", 1), FILES["px4"])


def test_the_worst_of_a_change_of_gains_and_configuration_is_told(tmp_path):
    proposed = "1\t1\tMC_ROLLRATE_P\t0.16\t9\n" + LINES["px4"].format("SENS_BOARD_ROT", 4)
    opinion = judged(tmp_path, proposed, FILES["px4"], source="px4")
    assert opinion.verdict == "not judged" and "SENS_BOARD_ROT 0 to 4" in opinion.document.sentence


def test_a_reset_returns_a_setting_to_its_default(tmp_path):
    present = BETAFLIGHT + "set align_board_yaw = 90\n"
    opinion = judged(tmp_path, "defaults nosave\n" + BETAFLIGHT, present)
    assert opinion.verdict == "not judged" and "align_board_yaw 90 to 0" in opinion.document.sentence
    assert ("align_board_yaw", "90", None) in [
        tuple(row.content().values()) for row in opinion.document.unmodeled_changes
    ]


BASELESS = {
    "no rate gain": ({"after": "1\t1\tMC_ROLL_P\t6.5\t9\n"}, "no gain of a rate loop is in after"),
    "no rate gain in the present": (
        {"after": FILES["px4"], "before": "1\t1\tMC_ROLL_P\t6.5\t9\n"}, "no gain of a rate loop is in before",
    ),
    "gains in another profile": (
        {"after": HEAD.format("2026.6") + "profile 1\nset p_roll = 50\nprofile 0\n"}, "no gain of a rate loop is in after",
    ),
    "PX4 of long ago": ({"after": PX4.format("1.8.2")}, "version 1.8; names and units are known of 1.11 to 1.17"),
    "PX4 to come": ({"after": PX4.format("2.0.0")}, "version 2.0"),
    "ArduPilot of long ago": ({"after": ARDUPILOT.format("3.1.5")}, "version 3.1; names and units are known of 3.3 to 4.8"),
    "Betaflight of long ago": ({"after": BETAFLIGHT.replace("2026.6", "4.2")}, "printed by Betaflight 4.2; known are Betaflight 4.3"),
    "Betaflight of an unknown version": ({"after": "set p_roll = 45\n"}, "no file states the firmware's version"),
    "an axis that cannot turn": ({"after": FILES["px4"] + "1\t1\tMC_ROLLRATE_MAX\t0\t9\n"}, "MC_ROLLRATE_MAX = 0"),
    "an axis that could not turn before either": (
        {
            "after": "1\t1\tMC_ROLLRATE_P\t0.2\t9\n1\t1\tMC_ROLLRATE_MAX\t0\t9\n",
            "before": FILES["px4"] + "1\t1\tMC_ROLLRATE_MAX\t0\t9\n",
        },
        "MC_ROLLRATE_MAX = 0",
    ),
    "settings of no loop alone": (
        {"after": "set osd_units = METRIC\nset f_roll = 90\n", "before": BETAFLIGHT},
        "nothing that the model flies differs, only: osd_units - to METRIC, f_roll - to 90",
    ),
    "a filter that does not act": (
        {
            "after": "set dterm_lpf1_static_hz = 150\n",
            "before": BETAFLIGHT + "set dterm_lpf1_dyn_min_hz = 75\nset dterm_lpf1_static_hz = 75\n",
        },
        "nothing that the model flies differs, only: dterm_lpf1_static_hz 75 to 150",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("files", "words"), BASELESS.values(), ids=BASELESS)
def test_without_a_basis_nothing_is_judged(files, words, tmp_path):
    opinion = judged(tmp_path, **files)
    assert opinion.verdict == "not judged" and words in opinion.document.sentence
    assert opinion.document.sentence.startswith("Not judged: ") and "Not judged, and not flown" in opinion.page


INAV = "# INAV/STM32F411CE 6.1.1 Oct  7 2023 / 00:35:33 (GITDIR-N)\nset {} = 40\n"
OTHERS = {
    "INAV": (INAV.format("mc_p_roll"), "INAV 6.1 is not supported"),
    "INAV with names of Betaflight": (INAV.format("p_roll"), "INAV 6.1 is not supported"),
    "INAV without its first line": ("set mc_p_roll = 40\n", "INAV is not supported"),
    "EmuFlight": (
        "# EmuFlight / F405 (F405) 0.4.1 Jan  1 2023 / 1:2:3 (a)\nset p_roll = 40\n",
        "EmuFlight 0.4 is not supported",
    ),
}


@pytest.mark.parametrize("source", [None, "betaflight"])
@pytest.mark.parametrize(("text", "words"), OTHERS.values(), ids=OTHERS)
def test_another_firmware_is_refused_by_its_name(text, words, source, tmp_path):
    for before in (None, BETAFLIGHT):
        with pytest.raises(tuner.InputError, match=words):
            judged(tmp_path, text, before, source=source)
    with pytest.raises(tuner.InputError, match=words):
        tuner.import_gains(write(tmp_path, text), "betaflight", "racer5", tmp_path / "gains.json")


VEHICLES = {
    "a banner": ("#NOTE: 2026 ArduPlane V4.5.1\nATC_RAT_RLL_P,0.1\n", "ArduPlane V4.5 is not supported"),
    "a line of QGroundControl": ("# Vehicle: Fixed Wing\nATC_RAT_RLL_P,0.1\n", "Fixed Wing is not supported"),
    "a parameter of a submarine": ("ATC_RAT_RLL_P,0.1\nFRAME_CONFIG,1\n", "ArduSub is not supported"),
    "a parameter of an aeroplane": ("ATC_RAT_RLL_P,0.1\nQ_ENABLE,1\n", "ArduPlane is not supported"),
}


@pytest.mark.parametrize(("text", "words"), VEHICLES.values(), ids=VEHICLES)
def test_another_vehicle_of_ardupilot_is_refused_by_its_name(text, words, tmp_path):
    with pytest.raises(tuner.InputError, match=words):
        judged(tmp_path, text)


def test_a_remark_with_a_slash_is_no_version(tmp_path):
    text = BETAFLIGHT + "# P/D ratio 1.2 is better\n"
    assert judged(tmp_path, text, BETAFLIGHT).verdict == "no practical difference"


@pytest.mark.parametrize(
    ("firmware", "version"), [("px4", "1.11.3"), ("px4", "1.17.0"), ("ardupilot", "3.3.3"), ("ardupilot", "4.8.0")]
)
def test_the_first_and_the_last_known_version_are_judged(firmware, version, tmp_path, monkeypatch):
    if firmware == "ardupilot":
        # Its laws are compiled for 9 s; margins and verdict are those of the file all the same.
        monkeypatch.setattr(assessing, "fly", lambda setups, *_: np.zeros((len(setups), len(setups[0].metrics), 2)))
    text = FILES[firmware].replace("1.16.0", version).replace("4.6.1", version)
    assert judged(tmp_path, text).verdict in ("no objection", "do not fly")


def test_an_export_is_judged_though_no_vehicle_printed_it(tmp_path):
    """Its comments name the releases that it is for."""
    gains = tuner.default_gains("pid", "pid", "racer5")
    folder = tuner.export(gains, "betaflight", tmp_path / "export", flights=2).folder
    for place in (folder, folder / "rollback"):
        assert tuner.judge(place / "gainproof.betaflight.txt", flights=2).verdict != "not judged"


def test_a_file_with_a_turned_board_is_judged_with_a_note(tmp_path):
    """A vehicle may carry its board turned: alone, the file is the vehicle's, and its gains are judged."""
    opinion = judged(tmp_path, FILES["px4"] + LINES["px4"].format("SENS_BOARD_ROT", 4))
    assert opinion.verdict == "no objection"
    assert opinion.document.unmodeled[0].endswith("flown as if it fitted the vehicle: SENS_BOARD_ROT = 4.")


def test_every_verdict_has_an_exit_code_and_refusals_are_those_above_0():
    assert set(EXIT_CODES) == set(VERDICTS) and set(REFUSED) == {"worse", "do not fly", "not judged"}
    assert (EXIT_CODES["better"], EXIT_CODES["worse"], EXIT_CODES["not judged"]) == (0, 1, 3)


def test_the_command_ends_with_3_and_leaves_page_document_and_rollback(tmp_path, tuner):
    present = write(tmp_path, BETAFLIGHT, "present.txt")
    proposed = write(tmp_path, "set align_board_yaw = 90\n", "proposed.txt")
    made = tuner("judge", proposed, "--before", present, "--out", tmp_path / "opinion")
    assert (
        made.returncode == 3 and "Not judged: changed orientation of a sensor: align_board_yaw 0 to 90" in made.stdout
    )
    document = AssessmentDocument.read(tmp_path / "opinion/assessment.json")
    assert document.verdict == "not judged" and document.rollback == "rollback/present.txt"
    assert (tmp_path / "opinion/judge.md").read_text().startswith("# Second opinion: not judged")
