"""The same calls of `import tuner` on every kind of plant: each gives its typed result, or a sentence on what to do instead."""

import json
import shutil
import subprocess
import tomllib
from dataclasses import dataclass
from pathlib import Path

import pytest

import tuner
from plant.errors import InputError, StoreError
from plant.own_code import run_own_code
from tests.clients import program
from tests.tuner.conftest import QUICKSTART, SMALL
from tests.tuner.experiments import own_motor
from tests.tuner.extensions.fmu.fmus import write_motor
from tests.undrawn import undrawn
from tuner.api.checking import Checked, Judgement
from tuner.api.designing import Design
from tuner.api.exporting import Exported
from tuner.api.flying import Flights
from tuner.api.margins import Margins
from tuner.extensions.processor_cost.api import Cost
from tuner.extensions.theory.api import Theory
from tuner.study.kinds import AnyStudy

STUDIES = QUICKSTART.parent
SHORT = {
    "search.algorithm": "nsga2",
    "search.population": 8,
    "search.generations": 2,
    "scenario.0.search": 4,
    "scenario.0.held_out": 8,
}
FMU = ('file = "dc_motor.py"', 'fmu = "motor.fmu"\ndisturbances = ["torque"]')
SLOW = [pytest.param(kind, marks=pytest.mark.slow) for kind in ("dc_motor", "heater", "fmu", "notebook")]
KINDS = ("quickstart", *SLOW)


@dataclass(frozen=True)
class Case:
    """A finished run: its results as `run` gave them, and the study that it was given."""

    kind: str
    results: tuner.TuningResults
    study: AnyStudy

    @property
    def is_quadrotor(self) -> bool:
        return self.kind == "quickstart"

    @property
    def gains(self) -> tuner.Gains:
        return self.results.nearest

    @property
    def forms(self) -> list[tuner.Gains | Path]:
        """The gains, their file, and the results folder; a notebook's plant lies in neither of the latter."""
        home = self.results.home
        return [self.gains] if self.kind == "notebook" else [self.gains, home / self.results.document.gains_file, home]


def study_of(kind: str, folder: Path) -> AnyStudy:
    if kind == "quickstart":
        return tuner.load_study("quickstart", {**SMALL, "scenario.0.held_out": 16})
    if kind == "dc_motor":
        return tuner.load_study("dc_motor", SHORT)
    if kind == "heater":
        few = {f"scenario.{i}.{key}": count for i in (0, 1) for key, count in (("search", 4), ("held_out", 8))}
        return tuner.load_study("heater", {**SHORT, **few, "scenario.0.duration": 30.0, "scenario.1.duration": 30.0})
    if kind == "fmu":
        write_motor(folder, 3)
        text = (STUDIES / "dc_motor.toml").read_text(encoding="utf-8").replace("lag = 0.001 ", "lag = 0.0 ")
        (folder / "motor.toml").write_text(text.replace(*FMU), encoding="utf-8")
        # Flown instance by instance in a process, some ten times slower.
        return tuner.load_study(folder / "motor.toml", {**SHORT, "scenario.0.search": 2, "scenario.0.held_out": 4})
    tables = tomllib.loads(own_motor.STUDY)
    del tables["plant"]["file"], tables["margin"]
    tables["search"] = {"algorithm": "nsga2", "population": 8, "generations": 2, "racing": False}
    tables["scenario"][0] |= {"search": 4, "held_out": 16}
    tables["constraint"] = [{"metric": "failure", "max": 0.0}]
    names = run_own_code(own_motor.write_motor(folder).with_name("motor.py")).names
    return tuner.make_study(tables, "motor", plant=names)


@pytest.fixture(scope="module", params=KINDS)
def case(request, tmp_path_factory) -> Case:
    folder = tmp_path_factory.mktemp(request.param)
    study = study_of(request.param, folder)
    with undrawn():
        results = tuner.run(study, folder / "run", threads=2)
    assert isinstance(results, tuner.TuningResults)
    return Case(request.param, results, study)


@pytest.fixture(autouse=True)
def named(case):
    """The user names the code, which no results folder may run by itself."""
    files = {"dc_motor": STUDIES / "dc_motor.py", "fmu": case.study.path.with_name("motor.fmu")}
    if case.kind in files:
        tuner.use(files[case.kind])


def test_gains_are_a_mapping_with_units_and_origin(case):
    gains = case.gains
    assert isinstance(gains, tuner.Gains) and gains.path is not None
    assert dict(gains) == {name: entry.value for name, entry in case.results.gains_document.gains.items()}
    assert gains.table["value"].to_dict() == dict(gains) and "" not in gains.table["unit"].tolist()
    assert gains.laws and gains.flown in repr(gains)
    default = case.results.default
    assert list(default) == list(gains) and default.flown == gains.flown and default.path is None
    assert default.document["study"]["point"] == "default"
    assert dict(case.results.gains(case.results.document.shown)) == pytest.approx(dict(gains))


def test_a_file_and_a_folder_read_as_the_same_gains(case):
    home = case.results.home
    for path in (home, home / case.results.document.gains_file):
        assert tuner.read_gains(path) == case.gains
    assert tuner.open_results(home, kind=tuner.TuningResults).nearest == case.gains
    with pytest.raises(StoreError, match="holds TuningResults, and kind = ContestResults"):
        tuner.open_results(home, kind=tuner.ContestResults)


def test_fly(case):
    flown = [tuner.fly(gains, flights=4) for gains in case.forms]
    assert all(isinstance(each, Flights) and each.count == 4 for each in flown)
    assert all(each.table.equals(flown[0].table) for each in flown)
    assert (
        tuner.fly(case.results.default, study=case.study, flights=2).scenario == flown[0].scenario or case.is_quadrotor
    )


def test_margins(case):
    read = [tuner.margins(gains) for gains in case.forms]
    assert all(isinstance(each, Margins) and each.table.equals(read[0].table) for each in read)
    assert tuner.margins(case.gains, study=case.study).document.channels == read[0].document.channels
    if not case.is_quadrotor:
        with pytest.raises(InputError, match="leave them out: a plant is linearised where it rests"):
            tuner.margins(case.gains, wind=3.0)


@pytest.mark.usefixtures("few_golden_vectors")
def test_export_is_verified_recorded_and_can_be_taken_back(case, tmp_path):
    # Where the run keeps its default, another of its named points flew before.
    flown = next(gains for gains in (case.results.default, *case.results.points.values()) if gains != case.gains)
    previous = flown.write(tmp_path / "previous.json")
    folders = []
    for k, gains in enumerate(case.forms[-1:] if case.kind == "fmu" else case.forms):
        made = tuner.export(gains, "c99", tmp_path / str(k), flights=2, previous=previous, force=True)
        folders.append(made.folder)
        assert isinstance(made, Exported)
        record = json.loads((made.folder / "export.json").read_text())
        verified = record["verification"]
        assert {row["gain"] for row in verified["gains"]} == set(case.gains)
        assert all(0.0 <= abs(row["relative"]) < 6e-8 for row in verified["gains"])
        assert verified["margins"] and {row["metric"] for row in verified["metrics"]} > {"failure"}
        assert made.passed == verified["passed"]
        exported = json.loads((made.folder / "gains.json").read_text())
        assert {entry["target"] for entry in exported["exports"]} == {"c99"}
        assert tuner.read_gains(made.folder / "gains.json") == case.gains
    again = tuner.export(flown, "c99", tmp_path / "default", flights=2, force=True)
    code = next(name for name in again.document.files if name.endswith("_controller.c"))
    if not case.is_quadrotor:
        # The code to go back to is that of the gains flown before.
        assert (folders[-1] / "rollback" / code).read_bytes() == (again.folder / code).read_bytes()
    assert (folders[-1] / "rollback" / code).read_bytes() != (folders[-1] / code).read_bytes()


def test_its_c_has_the_bits_of_its_golden_vectors(case, tmp_path):
    made = tuner.export(case.gains, "c99", tmp_path / "c", flights=2, force=True, options={"real": "double"})
    done = subprocess.run([program("make"), "test"], cwd=made.folder, capture_output=True, text=True)
    assert done.returncode == 0 and "the same bits" in done.stdout, done.stderr[-500:]


def test_a_target_of_quadrotors_says_so(case, tmp_path):
    if case.is_quadrotor:
        with pytest.raises(InputError, match="'px4' carries pid, px4 only"):
            tuner.export(case.gains, "px4", tmp_path / "x", force=True)
        return
    for target in ("px4", "matlab", "ros2", "rotorpy"):
        with pytest.raises(InputError, match=f"given {target}, which takes the loops of a quadrotor.*--to c99"):
            tuner.export(case.gains, target, tmp_path / "x", force=True)
    with pytest.raises(InputError, match="its loops are not those of the study|holds no gains of a plant"):
        file = tuner.default_gains("hybrid").write(tmp_path / "quad.json")
        tuner.export(case.gains, "c99", tmp_path / "x", previous=file, force=True)


def test_check_and_validate(case):
    for gains in case.forms:
        checked = tuner.validate(gains)
        assert isinstance(checked, Checked) and checked.kind == "gains" and not checked.hopeless, checked.content
    assert tuner.check(case.gains).content == tuner.validate(case.gains).content
    assert tuner.check(case.results.home / case.results.document.gains_file).kind == "gains"


def test_judge(case):
    for gains in case.forms:
        verdict = tuner.check_requirements(gains, case.study, flights=8)
        assert isinstance(verdict, Judgement) and verdict.verdict in ("pass", "fail", "not certain")


def test_compare(case, tmp_path):
    other = case.results.default.write(tmp_path / "other.json")
    if case.kind == "notebook":
        with pytest.raises(StoreError, match="no file holds the plant"):
            tuner.compare([case.results, other], flights=8)
    compared = tuner.compare([case.gains, other], study=case.study, flights=8)
    assert isinstance(compared, tuner.ComparisonResults)
    assert compared.summary.index.tolist() == ["run", "other"]
    in_memory = tuner.compare([case.gains, case.results.default], study=case.study, flights=8)
    assert in_memory.summary.index.tolist() == ["run", "gains-2"]
    assert in_memory.summary.to_numpy().tolist() == compared.summary.to_numpy().tolist()


def test_rejudge(case, tmp_path):
    changes = {"objective.0.risk": "quantile", "objective.0.level": 0.5}
    if case.kind == "notebook":
        with pytest.raises(StoreError, match="no file holds the plant"):
            tuner.rejudge(case.results.home, tmp_path / "judged", changes=changes)
        return
    judged = tuner.rejudge(case.results.home, tmp_path / "judged", changes=changes, threads=2)
    assert isinstance(judged, tuner.TuningResults) and "quantile50" in judged.summary.index[0]
    assert isinstance(judged.nearest, tuner.Gains)


def test_design(case, tmp_path):
    made = tuner.design(case.study, tmp_path / "designed.json")
    assert isinstance(made, Design) and isinstance(made.gains, tuner.Gains)
    assert set(made.gains) == set(made.default) == set(case.gains) and made.gains.path is not None
    if case.kind != "quickstart":
        # Designed gains lie in no results folder, but know their study.
        assert tuner.fly(made.gains, flights=2).count == 2
        with pytest.raises(InputError, match="lies in no results folder.*or the study too"):
            tuner.fly(made.gains.path)
        assert tuner.fly(made.gains.path, study=case.study, flights=2).count == 2


def test_theory(case):
    if case.is_quadrotor:
        assert isinstance(tuner.theory(case.gains), Theory)
        return
    for gains in case.forms:
        with pytest.raises(InputError, match="theorems speak of a quadrotor's axes.*--certificates"):
            tuner.theory(gains)


def test_cost(case):
    if case.is_quadrotor:
        assert isinstance(tuner.cost(case.gains), Cost)
        return
    for gains in case.forms:
        with pytest.raises(InputError, match="export it to c99.*make arm"):
            tuner.cost(gains)


def test_steps_of_first_flights_and_plans_are_of_quadrotors(case):
    if not case.is_quadrotor:
        with pytest.raises(InputError, match="first flights"):
            tuner.approach(case.gains, case.results.default)
        with pytest.raises(InputError, match="planned for a quadrotor"):
            tuner.plan_flight("crazyflie-pybullet", gains=case.gains)


def test_a_folder_that_was_copied_away_from_its_study_needs_it(case, tmp_path):
    """gains.json of a plant has its loops, but not its code."""
    if case.is_quadrotor:
        return
    alone = shutil.copy(case.gains.path, tmp_path / "alone.json")
    with pytest.raises(InputError, match="lies in no results folder"):
        tuner.margins(alone)
    assert tuner.margins(alone, study=case.study).document.channels
    with pytest.raises(InputError, match="flies no quadrotor"):
        tuner.read_gains(alone, airframe="f450")
