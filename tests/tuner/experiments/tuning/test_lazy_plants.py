"""Studies of plants of one's own with lazy objectives or a forgotten channel: none recommends what does nothing."""

import json

import numpy as np
import pytest

from objectives.metrics import parse
from objectives.plant_mission import REGULATED
from objectives.problem import FlightBatch, Objective, Problem
from objectives.risk import Risk
from plant.errors import InputError, UnknownNameError
from tests.tuner.experiments.tuning.lazy_plants import STUDIES
from tests.tuner.in_process import called
from tuner.experiments.tuning.conflicts import automatic_limit_texts
from tuner.experiments.tuning.guards import warnings_before_run
from tuner.study.kinds import load_gains_study
from tuner.study.plant_study import PlantStudy

MEDIAN = Risk("quantile", 0.5)
# Each compiles two loops; the motor stands for them in every run of the suite.
QUICK = ("motor",)


def median_errors(study, channel, scenario, rows):
    """RMS errors of a channel in flights that no part of the run made."""
    objective = Objective(parse(f"rms.{channel}", study.system.axes), MEDIAN, scenario)
    problem = Problem(study.system, study.space, (*study.objectives, objective), (), study.seed)
    batches = tuple(FlightBatch(entry.spec, "test", 16) for entry in study.scenarios)
    return problem.evaluate_gains(np.array(rows), batches, fly_all=True).values


@pytest.mark.parametrize(
    "lazy", [pytest.param(each, id=each.name, marks=() if each.name in QUICK else pytest.mark.slow) for each in STUDIES]
)
def test_what_does_nothing_wins_the_objectives_and_is_not_recommended(lazy, tmp_path):
    path = lazy.written(tmp_path)
    code, out, err = called("run", path, "--out", tmp_path / "r")
    assert code == 0, err
    study = load_gains_study(path, "a test")
    assert isinstance(study, PlantStudy)
    gains = json.loads((tmp_path / "r/gains.json").read_text(encoding="utf-8"))["gains"]
    tuned = [gains[gain.address]["value"] for gain in study.system.gains]
    idle = np.array(study.default_row)
    channel, scenario = lazy.forgotten or (study.system.plan.outer[0].name, study.scenarios[0].spec.name)
    for i, variable in enumerate(study.space.variables):
        if variable.name.startswith(channel):
            idle[study.space.columns[i][0]] = variable.low
    default, nothing, recommended = median_errors(study, channel, scenario, [study.default_row, idle, tuned])
    n = len(study.objectives)
    assert np.all(nothing[:n] <= 1.001 * default[:n])
    assert nothing[n] > 1.2 * default[n]
    assert recommended[n] < 0.8 * nothing[n]
    summary = json.loads((tmp_path / "r/summary.json").read_text(encoding="utf-8"))
    if lazy.forgotten:
        named = f'judges {channel} in scenario "{scenario}"'
        assert any(named in text for text in summary["warnings"])
        assert named in " ".join(out.split())
        assert named in (tmp_path / "r/report.html").read_text(encoding="utf-8").replace("&#34;", '"').replace(
            "&quot;", '"'
        )
    else:
        assert not any("No objective and no limit" in text for text in summary["warnings"])
    rows = {row["label"]: row for row in summary["table"] if row.get("automatic")}
    assert rows[f"quantile50(rms.{channel})@{scenario}"]["verdict"] in ("kept", "not certain")


@pytest.mark.slow
def test_a_channel_at_rest_that_nothing_judges_is_held_by_the_default(tmp_path):
    study = load_gains_study(STUDIES[0].written(tmp_path), "a test")
    assert isinstance(study, PlantStudy)
    limits = {entry.objective.label: entry for entry in study.automatic_limits}
    # Pan rests in the wind, and nothing moves it there.
    assert set(limits) == {"quantile50(rms.tilt)@wind", "quantile50(rms.pan)@slew", "quantile50(rms.tilt)@slew"}
    assert {label: entry.floor for label, entry in limits.items()} == {
        "quantile50(rms.tilt)@wind": "mission.held",
        "quantile50(rms.pan)@slew": "mission.followed",
        "quantile50(rms.tilt)@slew": "mission.off",
    }
    assert limits["quantile50(rms.tilt)@wind"].most == 0.5 * 3.0
    assert limits["quantile50(rms.pan)@slew"].most == pytest.approx(0.7 * 0.5)
    said = automatic_limit_texts([limits["quantile50(rms.tilt)@slew"]])
    assert "(automatic: 1.1 times the default's, mission.off)" in said[0]
    (default,) = median_errors(study, "tilt", "slew", [study.default_row])
    assert limits["quantile50(rms.tilt)@slew"].most == pytest.approx(REGULATED * default[-1], rel=0.1)


def limits_of(path, added=""):
    path.write_text(path.read_text(encoding="utf-8") + added, encoding="utf-8")
    return {entry.objective.label: entry.most for entry in load_gains_study(path, "a test").automatic_limits}


def motor(tmp_path):
    return next(each for each in STUDIES if each.name == "motor").written(tmp_path)


def test_the_table_of_quadrotors_moves_the_limits_of_plants(tmp_path):
    label = "quantile50(rms.angle)@turn"
    path = motor(tmp_path)
    usual, digest = limits_of(path), load_gains_study(path, "a test").digest()
    # A step of 1 rad from the first instant on.
    assert usual == {label: pytest.approx(0.7)}
    assert limits_of(path, "[mission]\nfollowed = 0.35\n") == {label: pytest.approx(0.35)}
    assert load_gains_study(path, "a test").digest() != digest


@pytest.mark.parametrize("off", ["rms.angle", "rms.angle@turn"])
def test_a_limit_that_is_switched_off_is_gone_and_named(tmp_path, off):
    path = motor(tmp_path)
    assert limits_of(path, f'[mission]\noff = ["{off}"]\n') == {}
    (said,) = [text for text in warnings_before_run(load_gains_study(path, "a test")) if "No objective" in text]
    assert 'judges angle in scenario "turn": mission.off leaves it without any limit' in said


def test_a_limit_of_its_own_on_the_same_quantity_takes_its_place(tmp_path):
    own = '[[constraint]]\nmetric = "rms.angle"\nrisk = "quantile"\nlevel = 0.5\nscenario = "turn"\nmax = 0.9\n'
    assert limits_of(motor(tmp_path), own) == {}


def test_nonsense_is_refused_with_its_key(tmp_path):
    with pytest.raises(UnknownNameError, match=r"mission.off: .*'rms.angel'.*did you mean 'rms.angle'"):
        limits_of(motor(tmp_path), '[mission]\noff = ["rms.angel"]\n')


def test_a_channel_without_a_limit_is_refused_where_it_would_have_an_automatic_one(tmp_path):
    path = motor(tmp_path)
    path.write_text(path.read_text(encoding="utf-8").replace("lost_beyond = 10.0\n", ""), encoding="utf-8")
    with pytest.raises(InputError, match=r"channel.angle.lost_beyond: an automatic limit judges 'rms.angle'"):
        load_gains_study(path, "a test")
