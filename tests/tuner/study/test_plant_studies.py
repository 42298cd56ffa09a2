"""The bundled studies of plants of one's own: each says what it asks, its default flies, its limits leave a choice, it runs."""

import json
import tomllib
from functools import cache

import numpy as np
import pytest

from objectives.problem import FlightBatch, Problem
from plant.errors import InputError
from plant.quadrotor.scenarios import SEARCH
from plant.seeds import generator
from tests.tuner.conftest import QUICKSTART
from tuner.api.studies import load_study
from tuner.documents.summary import GAINS
from tuner.experiments.tuning.run import TuningRun
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder
from tuner.study.plant_study import PlantStudy

FOLDER = QUICKSTART.parent
NAMES = sorted(
    file.stem for file in FOLDER.glob("*.toml") if "plant" in tomllib.loads(file.read_text(encoding="utf-8"))
)
each = pytest.mark.parametrize("name", NAMES)
# One plant flies in the usual run: kernels of the others take 3 s of compilation each, so they are slow proofs.
flown = pytest.mark.parametrize(
    "name", [name if name == "dc_motor" else pytest.param(name, marks=pytest.mark.slow) for name in NAMES]
)
# Draws of each scenario that the default flies; random candidates of which this share at least must keep the margins.
FEW, RANDOM, SHARE = 4, 128, 0.03


@cache
def study_of(name):
    return load_study(FOLDER / f"{name}.toml", kind=PlantStudy)


def test_every_plant_beside_the_studies_has_one():
    files = [
        name
        for name in NAMES
        if "file" in tomllib.loads((FOLDER / f"{name}.toml").read_text(encoding="utf-8"))["plant"]
    ]
    assert files == sorted(file.stem for file in FOLDER.glob("*.py"))


@each
def test_the_header_asks_a_question_and_tells_how_to_run_it(name):
    lines = (FOLDER / f"{name}.toml").read_text(encoding="utf-8").splitlines()
    header = [line for line in lines[:12] if line.startswith("#")]
    assert any(f"`tuner run studies/{name}.toml`" in line for line in header)
    assert "?" in " ".join(header) and 3 <= len(header)
    assert study_of(name).title and study_of(name).description.endswith(".")
    assert max(map(len, lines)) <= 130


@flown
def test_the_default_flies_every_scenario_and_limits_leave_a_choice(name):
    study = study_of(name)
    problem = Problem(study.system, study.space, study.objectives, study.constraints, study.seed, 2, study.screens)
    batches = tuple(FlightBatch(entry.spec, SEARCH, FEW) for entry in study.scenarios)
    default = problem.evaluate_gains(study.default_row[None], batches, fly_all=True)
    assert default.failures.tolist() == [0.0]
    points = generator(0, "bundled studies", 0).uniform(size=(RANDOM, len(study.space.variables)))
    if study.requirements:
        assert SHARE <= problem.worth_flying(points).mean() <= 0.95


@pytest.mark.slow
def test_the_motor_is_also_tuned_by_active_disturbance_rejection(tmp_path):
    """What the header of the study offers, typed in as it says."""
    text = (FOLDER / "dc_motor.toml").read_text(encoding="utf-8")
    text = text.replace('law = "pid"', 'law = "ladrc"\nb0 = 2122.0')
    gains = [line for line in text.splitlines() if line.startswith('"angle.')]
    ranges = [
        '"angle.omega_c" = { low = 5.0, high = 80.0, default = 20.0 }',
        '"angle.zeta" = 1.0',
        '"angle.omega_o" = { low = 20.0, high = 300.0, default = 80.0 }',
    ]
    text = text.replace("\n".join(gains), "\n".join(ranges))
    (tmp_path / "adrc.toml").write_text(text, encoding="utf-8")
    (tmp_path / "dc_motor.py").write_bytes((FOLDER / "dc_motor.py").read_bytes())
    study = load_study(tmp_path / "adrc.toml", kind=PlantStudy)
    problem = Problem(study.system, study.space, study.objectives, study.constraints, study.seed, 2, study.screens)
    default = problem.evaluate_gains(study.default_row[None], (FlightBatch(study.scenarios[0].spec, SEARCH, FEW),))
    assert default.failures.tolist() == [0.0] and default.flown.all()


@pytest.mark.slow
@each
def test_shortened_it_runs_to_a_complete_folder(name, tmp_path, monkeypatch):
    few = {
        f"scenario.{i}.{key}": count
        for i in range(len(study_of(name).scenarios))
        for key, count in (("search", 4), ("held_out", 8))
    }
    study = load_study(
        FOLDER / f"{name}.toml", {"search.population": 8, "search.generations": 4, **few}, kind=PlantStudy
    )
    monkeypatch.setattr("tuner.report.charts.paper.printed", lambda figure: {"": b""})
    outcome = TuningRun(study, Folder.create(tmp_path / name), Watcher(), threads=2).carry_out()
    assert json.loads((tmp_path / name / "summary.json").read_text())["feasible"]
    assert (tmp_path / name / GAINS).exists()
    assert not np.isnan(outcome.finalists.evaluation.requirements).any()


BAD = {
    "plant steps that do not divide": ({"plant.plant_step": 0.0003}, "multiple"),
    "a delay that does not divide": ({"actuator.0.delay": 0.0015}, "whole number"),
    "a parameter that is not there": ({"plant.parameters": {"inertai": 1.0}}, "inertia"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_numbers_are_told_with_their_key(name):
    changes, word = BAD[name]
    with pytest.raises(InputError, match=word) as caught:
        load_study(FOLDER / "dc_motor.toml", changes)
    assert "dc_motor.toml" in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("channel.0.lost_beyondd", "did you mean 'lost_beyond'"),
        ("plant.control_periode", "did you mean 'control_period'"),
        ("chanel", "did you mean 'channel'"),
        ("channel.0.rate", "did you mean 'rate_output'"),
    ],
)
def test_a_misspelt_key_is_told_with_those_of_its_table(key, said):
    with pytest.raises(InputError, match="unknown key") as told:
        load_study(FOLDER / "dc_motor.toml", {key: 1.0})
    assert said in str(told.value) and "airframe" not in str(told.value)


@pytest.mark.parametrize("given", [-3.0, {"low": -20.0, "high": -0.05}])
def test_gains_of_a_plant_that_falls_with_its_command_are_told_where_the_sign_belongs(given):
    with pytest.raises(InputError) as told:
        load_study(FOLDER / "dc_motor.toml", {"gains": gains_with("angle.kp", given)})
    assert told.value.key == "gains.angle.kp"
    assert "write b0 = -1 for channel 'angle'" in told.value.message


@pytest.mark.parametrize(("gain", "b0"), [("angle.t_f", 1.0), ("angle.kp", -1.0)])
def test_no_sign_is_advised_where_it_would_not_help(gain, b0):
    with pytest.raises(InputError, match="it must be") as told:
        load_study(FOLDER / "dc_motor.toml", {"channel.0.b0": b0, "gains": gains_with(gain, -0.5)})
    assert "b0" not in told.value.message


@pytest.mark.parametrize(
    "changes",
    [
        {"gains": ("angle.kp", {"low": 1.0, "high": 1e300})},
        {"gains": ("angle.kp", {"low": 1e-300, "high": 60.0, "scale": "log"})},
        {"gains": ("angle.kp", {"low": -1e308, "high": 1e308, "scale": "linear"})},
        {"gains": ("angle.kp", 1e300)},
        {"channel.0.b0": 1e-200},
        {"actuator.0.scale": 1e200},
    ],
)
def test_sizes_with_which_no_float_calculates_are_refused_at_once(changes):
    """A range to 1e300 sent `tuner check` away for minutes: margins of such gains overflow."""
    given = {key: gains_with(*value) if isinstance(value, tuple) else value for key, value in changes.items()}
    with pytest.raises(InputError, match="a size from 1e-30 to 1e\\+30") as error:
        load_study(FOLDER / "dc_motor.toml", given)
    assert next(iter(changes)).rpartition(".")[2].partition("[")[0] in error.value.key


def test_sizes_that_floats_calculate_with_are_taken():
    changes = {"gains": gains_with("angle.kp", {"low": 1e-30, "high": 1e30})}
    study = load_study(FOLDER / "dc_motor.toml", changes, kind=PlantStudy)
    [variable] = [each for each in study.space.variables if each.name == "angle.kp"]
    assert np.isfinite(variable.value(np.linspace(0.0, 1.0, 5))).all()


@pytest.mark.parametrize("command", ["check", "run"])
def test_a_range_that_no_search_can_cover_ends_a_command_within_seconds(command, tuner, tmp_path):
    out = ["--out", tmp_path / "r"] if command == "run" else []
    done = tuner(command, FOLDER / "dc_motor.toml", "--set", "gains.angle.kp.high=1e300", *out)
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert "gains.angle.kp.high: given 1e+300; allowed: 0, or a size from 1e-30 to 1e+30" in done.stderr
    assert not (tmp_path / "r").exists()


def gains_with(address, value):
    table = tomllib.loads((FOLDER / "dc_motor.toml").read_text(encoding="utf-8"))["gains"]
    return {**table, address: value}


def test_parameters_of_a_study_are_held_against_the_equations_at_rest():
    with pytest.raises(InputError, match=r"dc_motor.py:\d+: derivative: fails at rest: ZeroDivisionError"):
        load_study(FOLDER / "dc_motor.toml", {"plant.parameters": {"resistance": 0.0}})


def test_a_broken_plant_ends_a_check_as_a_study_that_names_it_does(tuner, tmp_path):
    text = (FOLDER / "dc_motor.py").read_text(encoding="utf-8")
    (tmp_path / "dc_motor.py").write_text(text.replace(" = 4.0", " = 0.0"), encoding="utf-8")
    (tmp_path / "dc_motor.toml").write_bytes((FOLDER / "dc_motor.toml").read_bytes())
    codes = [
        tuner(*command).returncode
        for command in (
            ("check", tmp_path / "dc_motor.py"),
            ("check", tmp_path / "dc_motor.toml"),
            ("run", tmp_path / "dc_motor.toml"),
        )
    ]
    assert codes == [2, 2, 2]
