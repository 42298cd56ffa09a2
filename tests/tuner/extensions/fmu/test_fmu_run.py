"""A study of an FMU: run to what the same plant in Python gives, verified, exported, and not run where nobody named it."""

import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from objectives.memory import flight_code
from objectives.problem import FlightBatch, Problem
from plant.errors import InputError
from plant.quadrotor.scenarios import SEARCH
from tests.tables import read_frame
from tests.tuner.conftest import QUICKSTART, NoDrawing
from tests.tuner.extensions.fmu.fmus import write_motor
from tests.tuner.in_process import called, tuner
from tuner import report
from tuner.api.studies import load_study
from tuner.documents.opening import open_results
from tuner.study.plant_study import PlantStudy

FOLDER = QUICKSTART.parent
MOTOR = (FOLDER / "dc_motor.toml").read_text(encoding="utf-8").replace("lag = 0.001 ", "lag = 0.0 ")
STUDY = MOTOR.replace('file = "dc_motor.py"', 'fmu = "motor.fmu"\ndisturbances = ["torque"]')
# A search that compares candidates alone goes the same way where they differ in the last bits.
SHORT = {
    "search.algorithm": "nsga2",
    "search.population": 8,
    "search.generations": 2,
    "scenario.0.search": 2,
    "scenario.0.held_out": 4,
}
SET = [word for key, value in SHORT.items() for word in ("--set", f"{key}={value}")]


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A folder with the motor as an FMU and in Python, and a study of each."""
    folder = tmp_path_factory.mktemp("fmu")
    write_motor(folder, 3)
    shutil.copy(FOLDER / "dc_motor.py", folder)
    (folder / "motor_fmu.toml").write_text(STUDY, encoding="utf-8")
    (folder / "motor_python.toml").write_text(MOTOR, encoding="utf-8")
    return folder


def run_of(folder, name, *changes):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report, "start_figures", lambda _: NoDrawing())
        patch.setattr(report, "write_report", lambda *_: None)
        patch.chdir(folder)
        code, out, err = called("run", f"{name}.toml", "--out", f"r_{name}", *SET, *changes)
    assert code == 0, err
    return folder / f"r_{name}", out + err


@pytest.fixture(scope="module")
def run(written):
    return run_of(written, "motor_fmu")[0]


def test_the_outcome_is_that_of_the_plant_in_python(run, written):
    other, _ = run_of(written, "motor_python")
    mine, theirs = (pd.read_csv(folder / "front.csv") for folder in (run, other))
    numbers = theirs.select_dtypes("number").columns
    assert list(mine.columns) == list(theirs.columns) and len(mine) == len(theirs)
    np.testing.assert_allclose(mine[numbers], theirs[numbers], rtol=1e-6, atol=1e-12)
    gains = [open_results(folder).gains_document.gains for folder in (run, other)]
    for address, entry in gains[1].items():
        assert gains[0][address].value == pytest.approx(entry.value, rel=1e-6), address


def test_an_angle_that_nothing_judges_is_held_by_the_default_as_in_python(written):
    found = []
    for text, name in ((STUDY, "forgotten_fmu"), (MOTOR, "forgotten_python")):
        path = written / f"{name}.toml"
        text = text.replace('[[objective]]\nmetric = "itae.angle"\n', "").replace(
            'reference.angle = { kind = "step", size', "#"
        )
        path.write_text(
            text.replace('metric = "overshoot.angle"\nmax = 10.0', 'metric = "failure"\nmax = 0.0'), encoding="utf-8"
        )
        found.append(load_study(path, SHORT, kind=PlantStudy).automatic_limits)
    (fmu,), (python,) = found
    assert (fmu.objective.label, fmu.floor) == ("quantile50(rms.angle)@turn", "mission.off")
    # The torque of 1 mN m turns the shaft; a default of 10 V/rad holds it to a small part of a radian.
    assert fmu.most == pytest.approx(python.most, rel=1e-6) and 1e-6 < fmu.most < 0.1


def test_what_flew_is_on_record(run):
    results = open_results(run)
    assert results.resolved.plant.fmu == "motor.fmu" and results.resolved.plant.file is None
    assert {fan.signal for fan in results.fans} == {"angle", "voltage"}
    assert (run / "inputs/motor.fmu").exists()


@pytest.mark.slow
def test_it_is_flown_again_to_the_same_bits(run, written, monkeypatch, capsys):
    code, out, err = tuner(monkeypatch, capsys, "verify", run, "--code", written / "motor_fmu.toml")
    assert code == 0, err
    assert "every bit is the same" in out


@pytest.mark.slow
def test_a_longer_budget_goes_on(run, written, monkeypatch, capsys, tmp_path):
    longer = shutil.copytree(run, tmp_path / "longer")
    assert tuner(monkeypatch, capsys, "resume", longer, "--budget", "3", "--code", written / "motor.fmu")[0] == 0
    assert (longer / "generations/0001.npz").read_bytes() == (run / "generations/0001.npz").read_bytes()
    assert (longer / "generations/0002.npz").exists()


def test_a_results_folder_runs_no_fmu_that_nobody_named(run, written, monkeypatch, capsys, tmp_path):
    monkeypatch.setattr("plant.own_code.HAVE_RUN", {})
    code, _, err = tuner(monkeypatch, capsys, "verify", run)
    assert code == 2 and "--code" in err and err.count("\n") == 1
    other = write_motor(tmp_path, 3, directional=False)
    code, _, err = tuner(monkeypatch, capsys, "verify", run, "--code", other)
    assert code == 2 and "changed since" in err


@pytest.mark.slow
def test_its_controller_is_c_with_the_bits_that_flew(run, written, monkeypatch, capsys, tmp_path):
    arguments = ("export", run / "gains.json", "--to", "c99", "--out", tmp_path / "c", "--code", written / "motor.fmu")
    code, _, err = tuner(monkeypatch, capsys, *arguments)
    assert code == 0, err
    if shutil.which("make") and shutil.which("cc"):
        made = subprocess.run(["make"], cwd=tmp_path / "c", capture_output=True, text=True, check=True)
        assert "the same bits" in made.stdout


@pytest.mark.slow
def test_a_crash_costs_the_candidate_and_not_the_run(written, tmp_path):
    write_motor(tmp_path, 2, "-DFAULT=CRASH")
    (tmp_path / "crash.toml").write_text(STUDY, encoding="utf-8")
    results, said = run_of(tmp_path, "crash", "--set", "plant.parameters={fault = 1.2}")
    assert " ".join(said.split()).count("it crashed (SIGABRT)") == 1
    generation = read_frame(results / "generations/0000.npz")
    failures = np.array(generation["failures"])
    assert failures.max(axis=0) > 0.0 and failures.min(axis=0) == 0.0


def test_a_cluster_flies_no_fmu(written, monkeypatch, capsys):
    code, _, err = tuner(
        monkeypatch, capsys, "run", written / "motor_fmu.toml", "--out", written / "d", "--dask", "local:1"
    )
    assert code == 2 and "an FMU flies in processes of this machine" in err


def test_check_tells_what_a_study_may_name(written, monkeypatch, capsys):
    code, out, err = tuner(monkeypatch, capsys, "check", written / "motor.fmu")
    assert code == 0, err
    for words in ("voltage V, torque N m", "angle rad", "angle, motor_speed", "resistance Ohm"):
        assert words in out


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('fmu = "motor.fmu"', 'fmu = "motor.fmu"\nfile = "dc_motor.py"', "plant: needs a file or an FMU, one of them"),
        ('fmu = "motor.fmu"', 'file = "dc_motor.py"', "plant.disturbances: belongs to an FMU"),
        ('fmu = "motor.fmu"', 'fmu = "none.fmu"', "there is no such file"),
        ('["torque"]', '["torqe"]', "plant.disturbances: unknown input 'torqe'; did you mean 'torque'?"),
        ('["torque"]', '["torque"]\nstates = ["spin"]', "plant.states: unknown variable 'spin'"),
        ('["torque"]', '["torque"]\nparameters = { inertai = 1.0 }', "did you mean 'inertia'?"),
        ('["torque"]', '["torque"]\npatience = 0.0', "plant.patience"),
        ('to = "voltage"', 'to = "torque"', "unknown input or channel 'torque'"),
    ],
)
def test_what_does_not_fit_is_one_line(written, tmp_path, old, new, said):
    assert old in STUDY
    for name in ("motor.fmu", "dc_motor.py"):
        shutil.copy(written / name, tmp_path)
    (tmp_path / "motor.toml").write_text(STUDY.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_study(tmp_path / "motor.toml")
    assert said in str(caught.value) and "\n" not in str(caught.value)


def test_the_shipped_example_flies_as_the_tool_builds_it(tmp_path):
    """The iron of the documentation, built by its own command, with margins by differences."""
    pytest.importorskip("pythonfmu")
    shutil.copytree(FOLDER / "from_fmu", tmp_path / "studies/from_fmu", ignore=shutil.ignore_patterns("*.fmu"))
    header = " ".join((FOLDER / "from_fmu/iron.toml").read_text(encoding="utf-8").replace("#", "").split())
    command = "pythonfmu build -f studies/from_fmu/iron.py -d studies/from_fmu"
    assert command in header
    from pythonfmu.builder import FmuBuilder

    FmuBuilder.build_FMU(tmp_path / "studies/from_fmu/iron.py", dest=tmp_path / "studies/from_fmu")
    study = load_study(tmp_path / "studies/from_fmu/iron.toml", kind=PlantStudy)
    problem = Problem(study.system, study.space, study.objectives, study.constraints, study.seed, 2, study.screens)
    flown = problem.evaluate_gains(study.default_row[None], (FlightBatch(study.scenarios[0].spec, SEARCH, 4),))
    assert flown.failures.tolist() == [0.0] and flown.flown.all()
    assert 1.0 < flown.requirements[0, 0] < 1.7


def test_units_and_names_of_the_example_are_those_of_its_study():
    table = tomllib.loads((FOLDER / "from_fmu/iron.toml").read_text(encoding="utf-8"))
    source = (FOLDER / "from_fmu/iron.py").read_text(encoding="utf-8")
    assert all(f'"{name}"' in source for name in table["plant"]["units"])
    page = (FOLDER.parent / "docs/fmu_plant.md").read_text(encoding="utf-8")
    shown = page.partition("```toml\n")[2].partition("```")[0]
    assert tomllib.loads(shown)["plant"] == table["plant"]


def test_without_the_extension_a_study_of_an_fmu_is_refused(written, monkeypatch):
    monkeypatch.setattr("tuner.extension.extensions", lambda: {})
    with pytest.raises(InputError, match="plant.fmu: no installed extension adds a kind of plant"):
        load_study(written / "motor_fmu.toml")


def test_keys_of_flights_hold_all_that_a_worker_runs_of_the_extension():
    program = (
        "import sys, tuner.extensions.fmu.worker, tuner.extensions.fmu.slope\n"
        "modules = [module for name, module in sys.modules.items() if name.startswith('tuner.')]\n"
        "print(*[module.__file__ for module in modules if not hasattr(module, '__path__')], sep='\\n')"
    )
    answer = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    files = set(map(Path, answer.splitlines()))
    assert {"worker.py", "flying.py", "instance.py", "slope.py"} <= {file.name for file in files}
    assert files <= set(flight_code().values())
