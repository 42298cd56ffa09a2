"""`tuner design` of a plant of one's own: what is printed is a study, what is written is gains that `tuner margins` takes."""

import json

import pytest
from typer.testing import CliRunner

import tuner
from tests.tuner.conftest import QUICKSTART
from tuner.api.studies import load_study
from tuner.cli.main import app
from tuner.study.plant_study import PlantStudy

MOTOR = QUICKSTART.parent / "dc_motor.toml"


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


def test_the_command_prints_it_and_another_law_is_said(tmp_path):
    told = CliRunner().invoke(
        app, ["design", str(MOTOR.with_name("two_masses.toml")), "--out", str(tmp_path / "g.json"), "--json"]
    )
    content = json.loads(told.stdout)
    assert [row["designed"] for row in content["design"]] == [False]
    assert "no designer for the law 'ladrc'" in content["warnings"][0]
    printed = CliRunner().invoke(app, ["design", str(MOTOR), "--out", str(tmp_path / "motor.json")])
    assert printed.exit_code == 0 and "[gains]" in printed.stdout and (tmp_path / "motor.json").exists()
    with pytest.raises(tuner.StoreError):
        tuner.design(MOTOR, tmp_path / "motor.json")
