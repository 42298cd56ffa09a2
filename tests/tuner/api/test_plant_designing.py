"""`tuner design` of a plant of one's own: what is printed is a study, what is written is gains that `tuner margins` takes."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import tuner
from tests.tuner.conftest import QUICKSTART
from tuner.api.designing import DesignedChannel
from tuner.api.studies import load_study
from tuner.cli.main import app
from tuner.study.plant_study import PlantStudy

MOTOR = QUICKSTART.parent / "dc_motor.toml"
UNSTABLE = """
title = "An unstable plant, with gains too small for it"
seed = 1
plant = { transfer_function = { numerator = [1.0], denominator = [1.0, 0.0, -1.0] }, control_period = 0.001 }
actuator = [{ name = "u", low = -20.0, high = 20.0 }]
channel = [{ name = "y", law = "pid", output = "y", to = "u", lost_beyond = 10.0 }]
scenario = [{ name = "step", duration = 2.0, search = 2, held_out = 2, reference.y = { kind = "step", size = 1.0 } }]
objective = [{ metric = "itae.y" }]
margin = [{ quantity = "ms", max = 2.0 }]

[gains]
"y.kp" = { low = 0.1, high = 50.0, default = 0.5 }
"y.ki" = { low = 0.01, high = 20.0, default = 0.1 }
"y.kd" = { low = 0.05, high = 20.0, default = 0.2 }
"y.t_f" = 0.001
"""


@pytest.fixture(scope="module")
def designed(tmp_path_factory):
    return tuner.design(MOTOR, tmp_path_factory.mktemp("design") / "designed.json")


def test_the_gains_written_keep_the_limit_of_the_study(designed):
    found = tuner.margins(designed.gains.path, study=MOTOR)
    assert found.passed and found.document.requirements[0].label == "ms"
    quantities = found.document.channels[0].quantities
    assert quantities["ms"].value == pytest.approx(designed.loops[0].ms)
    assert quantities["mt"].value == pytest.approx(designed.loops[0].mt)
    # The motor of the study asks for Ms of 1.8 at most, and the design stands at one of its two limits.
    shares = [(quantities[name].value or 0.0) / limit for name, limit in (("ms", 1.8), ("mt", 1.5))]
    assert max(shares) == pytest.approx(1.0, abs=0.02)


def test_the_table_that_is_printed_makes_the_design_the_default_of_the_study(designed, tmp_path):
    text = MOTOR.read_text(encoding="utf-8")
    before, rest = text.split("[gains]")
    (tmp_path / "again.toml").write_text(
        f"{before}{designed.toml}\n\n[[scenario]]{rest.split('[[scenario]]', 1)[1]}", encoding="utf-8"
    )
    (tmp_path / "dc_motor.py").write_bytes(MOTOR.with_name("dc_motor.py").read_bytes())
    assert load_study(tmp_path / "again.toml", kind=PlantStudy).default_row == pytest.approx(
        list(designed.gains.values()), rel=1e-5
    )


def test_a_designed_gain_at_the_end_of_its_range_is_named(designed):
    assert designed.gains["angle.ki"] == pytest.approx(200.0)
    assert designed.warnings == [
        "angle.ki = 200 is at the high end of its range, 200. Widen the range there if the vehicle allows."
    ]


def test_the_command_prints_it_and_another_law_is_said(tmp_path):
    told = CliRunner().invoke(
        app, ["design", str(MOTOR.with_name("two_masses.toml")), "--out", str(tmp_path / "g.json"), "--json"]
    )
    content = json.loads(told.stdout)
    assert told.exit_code == 1
    assert [row["designed"] for row in content["design"]] == [False]
    assert "no designer for the law 'ladrc'" in content["warnings"][0]
    printed = CliRunner().invoke(app, ["design", str(MOTOR), "--out", str(tmp_path / "motor.json")])
    assert printed.exit_code == 0 and "[gains]" in printed.stdout and (tmp_path / "motor.json").exists()
    with pytest.raises(tuner.StoreError):
        tuner.design(MOTOR, tmp_path / "motor.json")


@pytest.mark.parametrize("kd", [0.2, 0.1])
def test_an_unstable_plant_has_a_design_from_gains_that_do_not_hold_it(kd, tmp_path):
    # With 0.1 kp meets what the actuator allows before kd damps: no multiple of all three gains will do.
    (tmp_path / "unstable.toml").write_text(UNSTABLE.replace("default = 0.2", f"default = {kd}"), encoding="utf-8")
    designed = tuner.design(tmp_path / "unstable.toml")
    # Poles of (s^2 - 1) s + kd s^2 + kp s + ki: sampling and filter are 1000 times faster.
    poles = [np.roots([1.0, g["y.kd"], g["y.kp"] - 1.0, g["y.ki"]]).real for g in (designed.default, designed.gains)]
    assert poles[0].max(axis=0) > 0.0 > poles[1].max(axis=0)
    (loop,) = designed.loops
    assert designed.has_success and isinstance(loop, DesignedChannel) and 1.0 < (loop.ms or 0.0) <= 2.0


def test_a_design_names_the_limits_that_it_does_not_shape(tmp_path):
    limit = 'margin = [{ quantity = "ms", max = 2.0 }, { quantity = "phase_margin", min = 89.0 }]'
    text = UNSTABLE.replace('margin = [{ quantity = "ms", max = 2.0 }]', limit)
    (tmp_path / "limited.toml").write_text(text, encoding="utf-8")
    designed = tuner.design(tmp_path / "limited.toml")
    rows = {row.label: row for row in designed.margins["design"].requirements}
    assert rows["ms"].is_satisfied and not rows["phase_margin"].is_satisfied
    (line,) = [line for line in designed.warnings if "violates limits" in line]
    assert "phase_margin is 8" in line and "deg, min 89" in line and "ms is" not in line
