"""Designs before the search: `tuner design`, and `search.initial = ["default", "design"]`."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from objectives.design import design
from tests.tables import read_frame
from tests.tuner.conftest import QUICKSTART, run_small
from tuner.api import designing as command
from tuner.cli.main import app
from tuner.experiments.tuning import starts
from tuner.experiments.tuning.starts import design_row, loudest, starting_points, study_designs, without_design
from tuner.gains import read_gains
from tuner.study.build import load_study

BOTH = {"search.initial": ["default", "design"]}


@pytest.fixture(scope="module")
def study():
    return load_study(QUICKSTART, BOTH)


@pytest.fixture(scope="module")
def designs(study):
    return study_designs(study)


@pytest.fixture
def known(monkeypatch, designs):
    """Designs that are worked out once for all tests."""
    for module in (starts, command):
        monkeypatch.setattr(module, "study_designs", lambda _: designs)
    return designs


def test_the_row_is_that_of_the_designer_with_the_sensors_of_the_study(study, designs):
    assert study.scenarios[0].spec.sensors == loudest([entry.spec.sensors for entry in study.scenarios])
    theirs = design(study.system.cascade, study.system.nominal, study.system.timing)
    assert np.allclose(design_row(study, designs), theirs, rtol=1e-6)
    assert without_design(designs) == []


def test_starting_points_are_the_default_and_the_nearest_to_the_design(study, known):
    points, warnings = starting_points(study)
    row, space = design_row(study, known), study.space
    assert warnings == [] and points.shape == (2, len(space.variables))
    assert np.array_equal(points[0], space.point(study.default_row))
    values = space.values(points[1:])[0]
    for variable, columns, value in zip(space.variables, space.columns, values, strict=True):
        assert value == pytest.approx(np.clip(row[columns[0]], variable.low, variable.high), rel=1e-9)
    assert np.all((points >= 0.0) & (points <= 1.0))


def test_a_design_outside_the_ranges_starts_on_their_ends(known):
    narrow = load_study(QUICKSTART, {**BOTH, "gains.attitude.k2": {"low": 1.0, "high": 2.0}})
    i = next(i for i, variable in enumerate(narrow.space.variables) if variable.name == "attitude.k2")
    points, _ = starting_points(narrow)
    assert points[1, i] == 1.0


def test_the_default_is_first_even_where_it_is_not_named(known):
    only = load_study(QUICKSTART, {"search.initial": ["design"]})
    both, _ = starting_points(load_study(QUICKSTART, BOTH))
    assert np.array_equal(starting_points(only)[0], both)


def test_a_start_that_is_there_already_is_left_out_and_said(monkeypatch, study):
    monkeypatch.setitem(starts.STARTS, "design", starts.STARTS["default"])
    points, warnings = starting_points(study)
    assert len(points) == 1 and '"design"' in warnings[0]


def test_laws_without_designer_keep_their_defaults_with_a_warning(monkeypatch, study, designs):
    from dataclasses import replace

    one = replace(designs["yaw"], designed=False, why="there is no designer for the law adrc")
    monkeypatch.setattr(starts, "study_designs", lambda _: {**designs, "yaw": one, "roll": one})
    _, warnings = starting_points(study)
    assert warnings == ["No design for roll, yaw: there is no designer for the law adrc; the default gains stand in."]


def test_the_first_generation_holds_the_design_and_the_run_says_what_it_lacks(known, tmp_path, monkeypatch):
    from dataclasses import replace

    lacking = {**known, "yaw": replace(known["yaw"], designed=False, why="for a test")}
    monkeypatch.setattr(starts, "study_designs", lambda _: lacking)
    outcome = run_small(tmp_path / "run", search__initial=["default", "design"], search__generations=1)
    wanted, _ = starting_points(outcome.study)
    assert np.array_equal(outcome.generations[0].points[:2], wanted)
    table = read_frame(tmp_path / "run" / "generations" / "0000.npz")
    values = outcome.study.space.values(wanted)
    for i, variable in enumerate(outcome.study.space.variables):
        column = next(name for name in table.columns if name.endswith(variable.name))
        assert table[column].to_numpy()[:2] == pytest.approx(values[:, i])
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert any("No design for yaw: for a test" in warning for warning in summary["warnings"])


def test_without_being_asked_nothing_is_designed(monkeypatch):
    monkeypatch.setattr(starts, "study_designs", lambda _: pytest.fail("designed"))
    assert len(starting_points(load_study(QUICKSTART))[0]) == 1


def test_the_command_writes_gains_that_fly_and_compares_margins(study, known, tmp_path):
    path = tmp_path / "gains.json"
    done = CliRunner().invoke(app, ["design", str(QUICKSTART), "--out", str(path), "--json"])
    assert done.exit_code == 0, done.exception
    found = json.loads(done.stdout)
    controller = read_gains(path)
    assert controller.gains == pytest.approx(design_row(study, known), rel=1e-12)
    assert controller.options == study.options and controller.control_period == study.system.timing.control_period
    assert json.loads(path.read_text()) == found["gains"]
    assert set(found["margins"]) == {"default", "design"} and found["margins"]["design"]["passed"]
    assert [entry["axis"] for entry in found["design"]] == ["roll", "pitch", "yaw", "x", "y", "z"]
    judged = CliRunner().invoke(app, ["margins", str(path), "--json"])
    assert judged.exit_code == 0 and json.loads(judged.stdout)["channels"] == found["margins"]["design"]["channels"]


def test_the_command_prints_both_and_never_overwrites(known, tmp_path):
    path = tmp_path / "gains.json"
    done = CliRunner().invoke(app, ["design", str(QUICKSTART), "--out", str(path)])
    assert done.exit_code == 0 and "roll.k1" in done.stdout and "phase [deg]" in done.stdout
    assert "nearest point" in " ".join(done.stdout.split())
    before = path.read_bytes()
    again = CliRunner().invoke(app, ["design", str(QUICKSTART), "--out", str(path)])
    assert "exists already" in str(again.exception) and path.read_bytes() == before


def test_a_place_that_cannot_be_written_is_an_error(known, tmp_path):
    done = CliRunner().invoke(app, ["design", str(QUICKSTART), "--out", str(tmp_path / "no" / "gains.json")])
    assert "cannot be written" in str(done.exception)
