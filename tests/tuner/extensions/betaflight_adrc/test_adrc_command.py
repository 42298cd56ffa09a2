"""`tuner adrc`: a profile read, its forecast, and command lines that read back."""

import json
import re

import pytest

import tuner
from plant.errors import InputError
from tuner.cli.tables import wide_console
from tuner.extensions.betaflight_adrc.printer import print_adrc_forecast

PLANT = "[{axis}]\ngain = 13.2\nlag = 0.0256\ndelay = 0.0026\nzero = 0.13\n"


def own_plants(folder, **keys):
    path = folder / "craft.toml"
    text = "".join(PLANT.format(axis=axis) for axis in ("roll", "pitch", "yaw"))
    for key, value in keys.items():
        text = re.sub(rf"{key} = \S+", f"{key} = {value}", text)
    path.write_text(text)
    return path


def test_a_profile_is_forecast_with_the_margins_of_its_loop(vehicle):
    """Printed of this craft at 97/110: a line of 1.95 % at 58 Hz, where 70/80 is quiet; yaw is the axis."""
    document = tuner.adrc(vehicle(), gyro_rate=3205.0).document
    worst = document.rings[document.worst]
    assert (document.build, document.profile, document.schedule, worst.axis) == ("b11", 1, "FIXED", "yaw")
    assert worst.ring == pytest.approx(58.3, abs=2.0) and worst.gain_margin is not None and worst.gain_margin < 1.0
    assert not document.is_limit and "it is no limit" in document.sentence and not document.notes
    quiet = tuner.adrc(vehicle(), gyro_rate=3205.0, settings={"adrc_wc_yaw": 60, "adrc_wo_yaw": 70}).document
    gains = [next(row.gain_margin or 0.0 for row in each.rings if row.axis == "yaw") for each in (document, quiet)]
    assert gains[1] > 1.6 * gains[0]


def test_own_plants_make_a_limit(vehicle, tmp_path):
    document = tuner.adrc(vehicle(), gyro_rate=3205.0, plants=own_plants(tmp_path)).document
    assert document.is_limit and "The loop rings in flight." in document.sentence
    assert all(row.source == "given" and row.gain == 13.2 for row in document.plants)


def test_another_b0_in_the_file_is_another_plant_and_by_gain_another_tune(vehicle):
    """The margin follows the b0 of `--gain` alone, and the answer says so."""
    file, raised = (tuner.adrc(vehicle(adrc_b0_yaw=b0), gyro_rate=3205.0).document for b0 in ("3586", "4482"))
    changed = tuner.adrc(vehicle(), gyro_rate=3205.0, settings={"adrc_b0_yaw": 4482}).document
    margins = [document.rings[document.worst].gain_margin for document in (file, raised, changed)]
    assert margins[0] is not None
    assert margins[1] == pytest.approx(margins[0]) and margins[2] == pytest.approx(margins[0] * 4482 / 3586)
    assert "compares tunes on the same plants" in file.sentence


def test_written_lines_hold_the_tune_alone_and_read_back(vehicle, tmp_path):
    changes = {"adrc_wo_yaw": 80, "adrc_gyro_lpf_hz": 200}
    made = tuner.adrc(vehicle(), gyro_rate=3205.0, settings=changes, out=tmp_path / "lines.txt")
    lines = [line for line in made.lines.splitlines() if not line.startswith("#")]
    assert lines[0] == "profile 1" and lines[-1] == "save" and all(len(line) < 130 for line in made.lines.splitlines())
    names = [line.split()[1] for line in lines[1:-1]]
    # Nine of the axes, type, hover, law, and the other one that was changed.
    assert len(names) == 13 and "adrc_gyro_lpf_hz" in names and "adrc_ground_wc" not in names
    again = tuner.adrc(tmp_path / "lines.txt", gyro_rate=3205.0, build="b11", profile=1)
    assert again.profile.tune.numbers == made.profile.tune.numbers and again.profile.tune.schedule == "FIXED"


def test_the_answer_is_printed_and_is_json(vehicle, capsys):
    made = tuner.adrc(vehicle(), gyro_rate=3205.0)
    print_adrc_forecast(made, wide_console())
    printed = capsys.readouterr().out
    assert "Yaw rings first, at 59 Hz" in " ".join(printed.split()) and "QUADRATIC" in printed and "ground" in printed
    assert json.loads(made.json)["worst"] == made.document.worst


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"adrc_wc_yaw": "301"}, "adrc_wc_yaw: given 301 rad/s; give a whole number from 5 to 300"),
        ({"adrc_wc_yaw": "6.5"}, "adrc_wc_yaw: given '6.5'; this must be a whole number"),
        ({"adrc_motor_tau_ms": "20"}, "build b11 has no such setting; name the build by --build"),
        ({"adrc_magic": "1"}, "adrc_magic: build b11 has no such setting"),
        ({"adrc_b0_law": "CUBIC"}, "adrc_b0_law: given CUBIC; allowed: QUADRATIC, SQRT, LINEAR, FIXED"),
        ({"adrc_zeta_yaw": "175"}, "adrc_zeta_yaw: given 175 %; give a whole number from 0 to 100"),
        ({"thrust_linear": "150"}, "thrust_linear: given 150; allowed 0 to 100"),
        ({"pid_process_denom": "0"}, "pid_process_denom: given 0; allowed 1 to 16"),
    ],
)
def test_settings_that_are_refused_by_name(vehicle, changes, said):
    with pytest.raises(InputError, match=re.escape(said)):
        tuner.adrc(vehicle(**changes), gyro_rate=3205.0)


def test_a_classic_profile_is_refused_with_the_option(vehicle):
    with pytest.raises(InputError, match="profile 0 has pid_type = CLASSIC; give a profile with ADRC by --profile"):
        tuner.adrc(vehicle(), profile=0)


def test_an_unknown_build_gives_advice_and_no_file(vehicle, tmp_path):
    file = vehicle("0123456")
    assert any("Build not recognized (revision 0123456)" in note for note in tuner.adrc(file).document.notes)
    with pytest.raises(InputError, match="--out: the build is not recognized"):
        tuner.adrc(file, out=tmp_path / "lines.txt")
    with pytest.raises(InputError, match="b12"):
        tuner.adrc(file, build="b12")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[tail]\ngain = 1\n", "unknown key 'tail'; valid: pitch, roll, yaw"),
        ("roll = 3\n", "roll: given 3; this must be a table"),
        (PLANT.format(axis="yaw").replace("13.2", "nan"), "yaw.gain"),
        (PLANT.format(axis="yaw") + "mass = 1\n", "yaw.mass: unknown key 'mass'; valid: delay, gain, lag, zero"),
    ],
)
def test_plant_files_that_are_refused(vehicle, tmp_path, text, said):
    path = tmp_path / "craft.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=re.escape(said)):
        tuner.adrc(vehicle(), plants=path)


def test_thrust_linear_raises_the_gain_of_scaled_plants(vehicle):
    margins = [tuner.adrc(vehicle(thrust_linear=level)).document.rings[0].gain_margin or 0.0 for level in ("0", "60")]
    assert margins[0] / margins[1] == pytest.approx(1.36, rel=1e-6)


def test_gains_of_a_study_become_settings(vehicle, tmp_path):
    """Those of the law alone; a gains.json of another law is refused."""
    gains = tuner.default_gains("betaflight_adrc", airframe="racer5").replace({"yaw.wo": 71.6, "yaw.wc": 64.0})
    gains.write(tmp_path / "gains.json")
    made = tuner.adrc(vehicle(), gains=tmp_path / "gains.json", settings={"adrc_wc_yaw": 65})
    numbers = made.profile.tune.numbers
    assert (numbers["adrc_wo_yaw"], numbers["adrc_wc_yaw"], numbers["adrc_b0_yaw"]) == (72.0, 65.0, 2000.0)
    assert made.profile.tune.schedule == "SQRT" and "set adrc_b0_law = SQRT" in made.lines
    other = tmp_path / "other.json"
    tuner.default_gains("pid", airframe="racer5").write(other)
    with pytest.raises(InputError, match="given gains of pid; give those of a study"):
        tuner.adrc(vehicle(), gains=other)
