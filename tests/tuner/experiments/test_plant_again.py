"""Runs of a plant of one's own, judged anew, held against limits and laid side by side: from the flights that are on record."""

import json
from typing import Any

import numpy as np
import pytest

import tuner
from objectives.problem import FlightBatch, Problem
from plant.errors import InputError
from plant.quadrotor.scenarios import HELD_OUT
from tests.tuner.experiments.own_motor import write_motor
from tests.tuner.in_process import tuner as command
from tests.undrawn import undrawn
from tuner.api.studies import load_study
from tuner.experiments.compare.plan import COMPARE
from tuner.study.plant_study import PlantStudy

SMALL = {
    "search.algorithm": "nsga2",
    "search.population": 8,
    "search.generations": 2,
    "search.racing": False,
    "scenario.0.search": 4,
    "scenario.0.held_out": 32,
    "margin": [],
}
ADRC = {
    "channel.0.law": "ladrc",
    "channel.0.b0": 2122.0,
    "gains": {
        "angle.omega_c": {"low": 10.0, "high": 40.0},
        "angle.zeta": 1.0,
        "angle.omega_o": {"low": 40.0, "high": 120.0},
    },
}


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Two runs of the motor, under PID and under ADRC, and the study."""
    home = tmp_path_factory.mktemp("again")
    file = write_motor(home)
    with undrawn():
        for name, changes in (("pid", {}), ("adrc", ADRC)):
            tuner.run(load_study(file, SMALL | changes), out=home / name, threads=2)
    return home


@pytest.fixture(autouse=True)
def named(runs):
    """The code of the plant is named for every test, as by --code."""
    tuner.use(runs / "motor.py")


def csv(path):
    return np.genfromtxt(path, delimiter=",", names=True)


def test_a_judgement_takes_the_flights_that_are_there(runs):
    """By the worst flight in place of the mean: no candidate is flown again, so files of flights keep the digests in their names."""
    with undrawn():
        tuner.rejudge(runs / "pid", runs / "judged", changes={"objective.0.risk": "worst"}, threads=2)
    kept, taken = ({file.name for file in (runs / name / "flights").glob("search*")} for name in ("pid", "judged"))
    assert kept == taken and kept
    mean, worst = (csv(runs / name / "front.csv") for name in ("pid", "judged"))
    assert (worst["held_outworstitaeangle"][0] > mean["held_outmeanitaeangle"][0]).all()


def test_a_judgement_asks_for_no_other_flights(runs):
    with pytest.raises(InputError, match=r"\[scenario\] differs from the run's") as told:
        tuner.rejudge(runs / "pid", runs / "other", changes={"scenario.0.duration": 0.5})
    assert not (runs / "other").exists() and "\n" not in str(told.value)


def test_gains_are_judged_by_limits_on_flights_and_margins(runs):
    """The verdict on the limit of the study is that of its margins; one that nobody can keep fails."""
    study = load_study(runs / "motor.toml")
    judged = tuner.check_requirements(runs / "pid" / "gains.json", study, flights=32, threads=2)
    margins: Any = tuner.margins(runs / "pid" / "gains.json", study=study)
    assert judged.table.loc["ms", "value"] == pytest.approx(margins.table.loc["angle", "ms"], rel=1e-9)
    assert judged.verdict == ("pass" if margins.passed else "fail")
    strict = load_study(runs / "motor.toml", {"margin": [], "constraint": [{"metric": "itae.angle", "max": 1e-6}]})
    assert tuner.check_requirements(runs / "pid" / "gains.json", strict, flights=8).verdict == "fail"


def test_gains_of_other_loops_are_refused_with_all_that_differs(runs):
    with pytest.raises(InputError, match="law 'ladrc' instead of 'pid'; angle.b0 2122 instead of 1") as told:
        tuner.check_requirements(runs / "adrc" / "gains.json", load_study(runs / "motor.toml"))
    assert told.value.key == "channels" and told.value.file == str(runs / "adrc" / "gains.json")


def test_two_runs_fly_the_same_motors(runs):
    """Their values are those of problems of their own on the scenarios of the comparison."""
    found = tuner.compare([runs / "pid", runs / "adrc" / "gains.json"], flights=16, threads=2)
    assert [row.channels for row in found.document.contenders] == [{"angle": "pid"}, {"angle": "ladrc"}]
    values = {(row.contender, row.quantity): row.value for row in found.document.estimates}
    for name, changes in (("pid", {}), ("adrc", ADRC)):
        study = load_study(runs / "motor.toml", SMALL | changes, kind=PlantStudy)
        row = study.read_row(runs / name / "gains.json")
        problem = Problem(study.system, study.space, study.objectives, (), study.seed, 1)
        flown = problem.evaluate_gains(row[None], (FlightBatch(study.scenarios[0].spec, COMPARE, 16),)).values[0]
        assert [values[name, each.label] for each in study.objectives] == pytest.approx(flown, rel=1e-12)


def test_a_gains_file_alone_needs_a_study_and_flies_its_own_loops(runs):
    files = [runs / "pid" / "gains.json", runs / "adrc" / "gains.json"]
    with pytest.raises(InputError, match="--study"):
        tuner.compare(files)
    found = tuner.compare(files, study=runs / "motor.toml", flights=8, threads=2)
    assert [row.kind for row in found.document.contenders] == ["gains", "gains"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"control_period": {"value": 0.002, "unit": "s"}}, "control period of 0.002 s"),
        ({"channels": []}, "give at least one"),
        ({"channels": [{"name": "angle", "law": "pidd", "output": "angle", "to": "voltage"}]}, "did you mean 'pid'"),
        (
            {"channels": [{"name": "turn", "law": "pid", "output": "angle", "to": "voltage"}]},
            "compare loops for the same",
        ),
        ({"gains": {}}, "no number is given"),
        ({"version": 9}, "reads version 1"),
    ],
)
def test_a_gains_file_that_does_not_fit_is_told_in_a_line(runs, tmp_path, change, words):
    document = json.loads((runs / "pid" / "gains.json").read_text(encoding="utf-8"))
    (tmp_path / "gains.json").write_text(json.dumps(document | change), encoding="utf-8")
    with pytest.raises(InputError, match=words) as told:
        tuner.compare([runs / "pid", tmp_path / "gains.json"], flights=8)
    assert "\n" not in str(told.value) and str(told.value).startswith(str(tmp_path))


def test_a_plant_and_a_quadrotor_are_not_compared(runs):
    with pytest.raises(InputError, match="compare controllers of one kind"):
        tuner.compare([runs / "pid", runs / "pid" / "gains.json"], study="quickstart")


def test_gains_fly_a_scenario_of_their_own_study(runs):
    """Every mean is that of the problem of the study on the same held-out flights."""
    flown = tuner.fly(runs / "pid" / "gains.json", flights=8, threads=2)
    study = load_study(runs / "motor.toml", SMALL, kind=PlantStudy)
    row = study.read_row(runs / "pid" / "gains.json")
    problem = Problem(study.system, study.space, study.objectives, (), study.seed, 1)
    values = problem.evaluate_gains(row[None], (FlightBatch(study.scenarios[0].spec, HELD_OUT, 8),)).scores[0]
    means = [flown.table.loc[str(each.metric), "mean"] for each in study.objectives]
    assert means == pytest.approx(values.mean(axis=1), rel=1e-12)
    assert flown.recorded.signals == ("angle", "voltage")


def test_flying_and_theory_of_a_plant_are_told_at_the_command_line(runs, monkeypatch, capsys):
    gains, code = runs / "pid" / "gains.json", ("--code", runs / "motor.py")
    told, out, err = command(monkeypatch, capsys, "fly", gains, "--seeds", "4", *code)
    assert told == 0, err
    assert "pid (angle): step, 4 flights of 0.6 s" in out and "itae.angle" in out and "position" not in out
    told, out, err = command(monkeypatch, capsys, "theory", gains, *code)
    assert told == 2 and err.count("\n") == 1 and "--certificates" in err
