"""Sliders of simplified tuning against the firmware's own code for a board's processor, and against what boards have printed."""

from pathlib import Path

import pytest

from plant.errors import InputError
from tests.tuner.exchange.reading import write
from tuner.extensions.betaflight.commands import read_cli
from tuner.extensions.betaflight.map import RELEASES
from tuner.extensions.betaflight.sliders import applied_settings

TABLE = Path(__file__).with_name("sliders.txt")
ROWS = [line for line in TABLE.read_text().splitlines() if not line.startswith("#")]
MODES = {"1": "RP", "2": "RPY"}
CUTOFFS = ("lpf1_dyn_min_hz", "lpf1_dyn_max_hz", "lpf1_static_hz", "lpf2_static_hz")
BANNER = "# Betaflight / STM32F7X2 (S7X2) {}.1 Dec 20 2025 / 18:22:02 (77d01ba3b) MSP API: 1.47\n"
PRINTED = {
    # Dumps in public repositories, which hold the sliders and the gains that the board worked out of them.
    "a Cinelog35 of 4.5": (
        "4.5",
        "i_gain 120 d_gain 120 pi_gain 110 dmax_gain 0 feedforward_gain 85 dterm_filter_multiplier 95",
        "p_pitch 51 i_pitch 110 d_pitch 40 f_pitch 106 p_roll 49 i_roll 105 d_roll 35 f_roll 101 p_yaw 49 i_yaw 105 f_yaw 101 "
        "d_min_roll 35 d_min_pitch 40 dterm_lpf1_dyn_min_hz 71 dterm_lpf1_dyn_max_hz 142 dterm_lpf2_static_hz 142",
    ),
    "a 5 inch of 4.5": (
        "4.5",
        "master_multiplier 105 pi_gain 120 feedforward_gain 110",
        "p_pitch 59 i_pitch 105 d_pitch 48 f_pitch 144 p_roll 56 i_roll 100 d_roll 42 f_roll 138 d_min_roll 31 d_min_pitch 35",
    ),
    "a whoop of 2025.12": (
        "2025.12",
        "master_multiplier 120 d_gain 110 pi_gain 130 feedforward_gain 20 pitch_pi_gain 120 dterm_filter_multiplier 110",
        "p_pitch 87 i_pitch 157 d_pitch 44 f_pitch 35 p_roll 70 i_roll 124 d_roll 39 f_roll 28 p_yaw 70 i_yaw 124 f_yaw 28 "
        "d_max_roll 52 d_max_pitch 60 dterm_lpf1_static_hz 82 dterm_lpf1_dyn_max_hz 165",
    ),
}


def pairs(text: str) -> dict[str, str]:
    words = text.split()
    return dict(zip(words[::2], words[1::2], strict=True))


@pytest.mark.parametrize("row", ROWS, ids=range(len(ROWS)))
def test_gains_are_those_of_the_firmware(row, tmp_path):
    given, gains, cutoffs = (part.split() for part in row.split("|"))
    release, mode, master, pi, i, d, d_max, feedforward, pitch_d, pitch_pi, dterm, gyro = given
    is_old = release == "4.5"
    sliders = pairs(
        f"pids_mode {MODES[mode]} master_multiplier {master} pi_gain {pi} i_gain {i} d_gain {d} feedforward_gain {feedforward} "
        f"{'dmax_gain' if is_old else 'd_max_gain'} {d_max} pitch_d_gain {pitch_d} pitch_pi_gain {pitch_pi} "
        f"dterm_filter_multiplier {dterm} gyro_filter_multiplier {gyro}"
    )
    stored = applied_settings({f"simplified_{k}": v for k, v in sliders.items()}, RELEASES[release], tmp_path)
    wanted = {f"{filtered}_{name}": cutoffs.pop(0) for filtered in ("dterm", "gyro") for name in CUTOFFS}
    for axis in ("roll", "pitch", "yaw")[: int(mode) + 1]:
        names = ("p", "i", *(("d_min", "d") if is_old else ("d", "d_max")), "f")
        wanted |= {f"{name}_{axis}": gains.pop(0) for name in names}
    assert stored == wanted


@pytest.mark.parametrize(("release", "sliders", "gains"), PRINTED.values(), ids=PRINTED)
def test_gains_are_those_that_boards_print(release, sliders, gains, tmp_path):
    lines = [f"set simplified_{name} = {value}" for name, value in pairs(sliders).items()]
    file = write(tmp_path, BANNER.format(release) + "\n".join(["profile 0", *lines, "simplified_tuning apply"]))
    values = read_cli(file, 0)
    assert {name: values[name] for name in pairs(gains)} == pairs(gains)


def test_sliders_without_apply_change_nothing(tmp_path):
    text = "profile 0\nset p_roll = 50\nset simplified_master_multiplier = 150\n"
    assert read_cli(write(tmp_path, text), 0)["p_roll"] == "50"
    disabled = read_cli(write(tmp_path, f"{text}simplified_tuning disable\nsimplified_tuning apply\n"), 0)
    assert disabled["p_roll"] == "50" and "gyro_lpf2_static_hz" not in disabled


def test_apply_takes_the_sliders_of_its_line_and_later_lines_replace_it(tmp_path):
    text = "set simplified_pi_gain = 200\nsimplified_tuning apply\nset simplified_pi_gain = 50\nset i_roll = 7\n"
    values = read_cli(write(tmp_path, text), 0)
    # Twice the defaults 45 and 80, of which the latter is set by hand.
    assert (values["p_roll"], values["i_roll"], values["i_yaw"]) == ("90", "7", "160")


def test_a_low_pass_that_is_off_stays_off(tmp_path):
    text = "set gyro_lpf1_dyn_min_hz = 0\nset gyro_lpf1_static_hz = 0\nset simplified_gyro_filter_multiplier = 50\n"
    values = read_cli(write(tmp_path, f"{text}simplified_tuning apply\n"), 0)
    assert (values["gyro_lpf1_dyn_min_hz"], values["gyro_lpf1_static_hz"], values["gyro_lpf2_static_hz"]) == (
        "0",
        "0",
        "250",
    )
    assert "gyro_lpf1_dyn_max_hz" not in values


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("simplified_pi_gain = 201", "simplified_pi_gain: given 201; allowed 0 to 200"),
        ("simplified_gyro_filter_multiplier = 9", "simplified_gyro_filter_multiplier: given 9; allowed 10 to 200"),
        ("simplified_d_gain = 1.5", "simplified_d_gain: given '1.5'; this must be a whole number"),
        ("simplified_pids_mode = ALL", "simplified_pids_mode: given 'ALL'; allowed: OFF, RP, RPY"),
    ],
)
def test_a_slider_that_the_firmware_refuses_is_refused(line, words, tmp_path):
    with pytest.raises(InputError, match=f"vehicle.txt: {words}"):
        read_cli(write(tmp_path, f"set {line}\nsimplified_tuning apply\n"), 0)
