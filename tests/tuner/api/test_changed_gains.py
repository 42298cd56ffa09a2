"""Gains with other values, in Python and by --gain, and the default gains of a study in place of a file."""

import json

import numpy as np
import pytest

import tuner as interface
from plant.errors import InputError
from tests.tuner.conftest import QUICKSTART
from tests.tuner.in_process import tuner
from tuner.cli.printers.gains import SPARKS, sparks
from tuner.study.plant_study import PlantStudy
from tuner.text.pairs import named_number, named_text

MOTOR = str(QUICKSTART.with_name("dc_motor.toml"))


def test_changed_gains_have_the_margins_of_a_study_with_that_default():
    changed = interface.read_gains(MOTOR).replace(kp=12.5, kd=0.3)
    study = interface.load_study(
        MOTOR, {"gains.angle.kp.default": 12.5, "gains.angle.kd.default": 0.3}, kind=PlantStudy
    )
    found, right = (interface.margins(each, study=study) for each in (changed, interface.read_gains(MOTOR)))
    default = study.controller(study.default_row).gains
    assert dict(changed) == default and dict(changed) != dict(interface.read_gains(MOTOR))
    again = interface.margins(interface.read_gains(MOTOR).replace(default), study=study)
    assert found.document.channels == again.document.channels != right.document.channels


def test_a_quadrotors_changed_gains_are_a_file_that_is_valid(tmp_path):
    changed = interface.default_gains("pid").replace({"roll.kp": 41.0, "yaw.kp": 3.0})
    again = interface.read_gains(changed.write(tmp_path / "gains.json"))
    assert (again["roll.kp"], again["yaw.kp"]) == (41.0, 3.0)
    assert {k: v for k, v in again.items() if k not in ("roll.kp", "yaw.kp")} == {
        k: v for k, v in interface.default_gains("pid").items() if k not in ("roll.kp", "yaw.kp")
    }


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"kp": 2.0}, "'kp', which several loops have; write one of .*roll.kp"),
        ({"roll.kq": 2.0}, "unknown gain 'roll.kq'"),
        ({"roll.kp": -2.0}, "must be above 0"),
        ({"roll.kp": float("nan")}, "nan"),
    ],
)
def test_a_wrong_change_is_refused(changes, said):
    with pytest.raises(InputError, match=said):
        interface.default_gains("pid").replace(changes)


def test_a_command_takes_a_study_and_other_values(monkeypatch, capsys):
    code, out, _ = tuner(monkeypatch, capsys, "margins", MOTOR, "--gain", "kp=30")
    assert code == 1 and "NO" in out and "All plant inputs" not in out
    row = next(line for line in out.splitlines() if line.startswith("phase"))
    assert row.split()[-1] == "-"
    code, out, _ = tuner(monkeypatch, capsys, "margins", MOTOR, "--gain", "angle.kp=12")
    assert code in (0, 1) and "yes" in out and "Required by the study" in out
    code, _, error = tuner(monkeypatch, capsys, "margins", MOTOR, "--gain", "kp")
    assert code == 2 and "NAME=VALUE" in error


def test_the_blocks_of_a_response_end_with_its_last_flight():
    assert sparks(np.array([0.0, 1.0, np.nan, np.inf]), 0.0, 1.0) == f"{SPARKS[0]}{SPARKS[-1]}  "
    assert sparks(np.array([2.0, np.nan]), 2.0, 2.0) == f"{SPARKS[0]} "


def test_a_comparison_takes_a_study_and_the_first_with_other_values(monkeypatch, capsys):
    code, out, error = tuner(
        monkeypatch, capsys, "compare", MOTOR, "--gain", "kp=20", "--gain", "kd=0.4", "--seeds", "8", "--json"
    )
    assert code == 0, error
    document = json.loads(out)
    first, second = document["contenders"]
    assert (first["name"], second["name"], second["source"]) == ("dc_motor", "gains-2", "gains-2")
    changed = interface.read_gains(MOTOR).replace(kp=20.0, kd=0.4)
    assert {name: entry["value"] for name, entry in second["gains"].items()} == dict(changed)
    assert first["gains"]["angle.kp"]["value"] == 10.0


def test_a_judgement_takes_a_gains_file_and_other_values(monkeypatch, capsys, tmp_path):
    file = interface.default_gains("pid").write(tmp_path / "gains.json")
    judged = []

    def judge(after, before, **_):
        judged.append((dict(after), before))
        raise InputError("far enough")

    monkeypatch.setattr(interface, "judge", judge)
    code, _, error = tuner(monkeypatch, capsys, "judge", str(file), "--gain", "roll.kp=41")
    assert code == 2 and "far enough" in error
    assert judged == [(dict(interface.read_gains(file)) | {"roll.kp": 41.0}, file)]
    code, _, error = tuner(monkeypatch, capsys, "judge", "new.txt", "--gain", "roll.kp=41")
    assert code == 2 and "--gain: changes gains of a gains.json; edit a copy of new.txt" in error


@pytest.mark.parametrize("given", ["kp", "=3", "kp=", "kp=a"])
def test_an_option_of_another_form_is_refused_with_an_example(given):
    with pytest.raises(InputError, match="--gain: given '.*for instance kp=2"):
        named_number(given, "--gain", "kp=2")


def test_an_option_may_hold_more_equal_signs():
    assert named_text(" a = b=c ", "--set", "x=1") == ("a", "b=c")
