"""Files of one's own in a study: their names, their digests, and that a results folder never runs what nobody named."""

import json
import pickle
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

import tuner
from objectives.flown_system import FlightBatch
from objectives.memory import scenario_key
from objectives.metrics import METRICS
from plant import own_code
from plant.errors import InputError, UnnamedCodeError
from plant.law_registry import LAWS
from plant.registry import Registry
from plant.texts import PlainTable
from tests.plant.own_files import LAW, METRIC, REFERENCE, SWAY, edited, forget, line_of
from tests.tuner.experiments.own_motor import write_motor
from tuner.cli.app import with_code_first
from tuner.documents.resolved import Resolved
from tuner.extensions.cluster.brief import brief_of, system_of
from tuner.gains.examining import examine
from tuner.store.folder import Folder
from tuner.store.inputs import freeze
from tuner.study.files import SHIPPED
from tuner.study.kinds import load_gains_study, load_tuning
from tuner.study.own_code import use, use_named
from tuner.study.study import Study
from tuner.text.errors import guarded

STUDY = SHIPPED / "own_law.toml"


@pytest.fixture
def home(tmp_path: Path) -> Path:
    """A copy of the shipped study with its files."""
    shutil.copy(STUDY, tmp_path)
    shutil.copytree(LAW.parent, tmp_path / "own_law", ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path / "own_law.toml"


def own_study(path: Path) -> Study:
    """Return the study of a file."""
    return load_tuning(path, "test")


def rewritten(file: Path, *changes: tuple[str, str]) -> None:
    """Change a file in its place."""
    edited(file, file.parent, *changes)


def test_a_study_flies_what_its_files_define(home: Path) -> None:
    study = own_study(home)
    assert study.system.cascade.attitude is LAWS["pid_plain"]
    assert study.objectives[0].label == "mean(mae.position)"
    assert study.scenarios[0].spec.reference.kind == "circle"
    resolved: dict[str, Any] = study.resolved()
    assert set(resolved["law"]) == {"pid_plain"} and "pid_plain.py" not in json.dumps(resolved["law"])


def test_the_digest_of_a_study_is_that_of_its_code_wherever_it_lies(home: Path, tmp_path: Path) -> None:
    here = own_study(home).digest()
    shutil.copytree(home.parent / "own_law", tmp_path / "elsewhere" / "own_law")
    shutil.copy(home, tmp_path / "elsewhere" / "another_name.toml")
    forget()
    assert own_study(tmp_path / "elsewhere" / "another_name.toml").digest() == here
    digests = {here}
    for name in ("pid_plain.py", "mae.py", "circle.py"):
        with (home.parent / "own_law" / name).open("a") as file:
            file.write("# changed\n")
        forget()
        digests.add(own_study(home).digest())
    assert len(digests) == 4


def test_a_study_of_a_plant_takes_a_list_of_files_by_their_digests(tmp_path: Path) -> None:
    for file in (LAW, METRIC, SWAY):
        shutil.copy(file, tmp_path)
    path = write_motor(tmp_path)
    changes: PlainTable = {
        "metric.file": ["mae.py", "sway.py"],
        "law.file": [LAW.name],
        "objective.0.metric": "mae.angle",
    }
    study = load_gains_study(path, "test", changes)
    resolved = Resolved.model_validate_json(json.dumps(study.resolved()))
    origin = METRICS["mae"].origin
    assert origin is not None and resolved.metric == {"mae": origin.digest} and resolved.law is None
    with (tmp_path / "mae.py").open("a") as file:
        file.write("# changed\n")
    forget()
    assert load_gains_study(path, "test", changes).digest() != study.digest()


def test_recorded_flights_are_those_of_the_code_of_law_and_reference_and_of_what_a_metric_adds_up(home: Path) -> None:
    def key() -> str:
        forget()
        study = own_study(home)
        return scenario_key(study.system, study.seed, FlightBatch(study.scenarios[0].spec, "search", 4))

    keys = [key()]
    for name in ("mae.py", "pid_plain.py", "circle.py"):
        with (home.parent / "own_law" / name).open("a") as file:
            file.write("# changed\n")
        keys.append(key())
    assert keys[0] == keys[1] and len(set(keys)) == 3
    rewritten(home.parent / "own_law" / "sway.py", ("state.way + absolute", "state.way + 0.5 * absolute"))
    assert key() not in keys, "what a metric adds up itself is flown with"


def test_a_file_read_again_is_the_same_and_an_edited_one_takes_its_place(tmp_path: Path) -> None:
    file = edited(LAW, tmp_path)
    first = use(file)
    assert use(file) is first
    rewritten(file, ('title="PID without', 'title="My PID without'))
    use(file)
    assert LAWS["pid_plain"].title == "My PID without a derivative filter"


def test_names_belong_to_one_file_each(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="'pid' is a law of gainproof itself; give yours another name"):
        use(edited(LAW, tmp_path, ('name="pid_plain"', 'name="pid"')))
    use(LAW)
    with pytest.raises(InputError, match="is the law of .* already"):
        use(edited(LAW, tmp_path, ('title="PID', 'title="Another PID'), name="other.py"))


def test_a_file_tells_what_it_defines(tmp_path: Path) -> None:
    file = tmp_path / "nothing.py"
    file.write_text("x = 1\n")
    with pytest.raises(InputError, match="defines no LAW or METRIC or REFERENCE"):
        use(file)
    both = edited(LAW, tmp_path, ("LAW = Law(", "METRIC = 1\nLAW = Law("), name="both.py")
    with pytest.raises(InputError, match="defines LAW and METRIC; put each into a file of its own"):
        use(both)
    with pytest.raises(InputError, match="which gains.json has no code"):
        use(edited(LAW, tmp_path, ('"kd", "kd", "s^-1"', '"kd", "kd", "furlong"'), name="unit.py"))


def test_a_key_or_a_file_that_is_not_there_is_told(home: Path) -> None:
    rewritten(home, ('file = "own_law/pid_plain.py"', 'path = "own_law/pid_plain.py"'))
    with pytest.raises(InputError, match=r"law.path: unknown key 'path'; valid: file"):
        own_study(home)
    rewritten(home, ('path = "own_law/pid_plain.py"', 'file = "own_law/none.py"'))
    with pytest.raises(InputError, match="none.py: there is no such file"):
        own_study(home)
    rewritten(home, ('file = "own_law/none.py"', 'file = ["own_law/pid_plain.py"]'))
    assert own_study(home).system.laws["attitude"].name == "pid_plain"


@dataclass(frozen=True)
class Recorded:
    """A results folder with the inputs of a run, and a file that its code would write if it ran."""

    path: Path
    study: Path
    marker: Path


@pytest.fixture
def recorded(home: Path, tmp_path: Path) -> Recorded:
    """The inputs of a run of the shipped study, whose law tells when it runs and imports a file from beside it."""
    marker = tmp_path / "it_ran"
    (home.parent / "own_law" / "beside.py").write_text(f"from pathlib import Path\nPath({str(marker)!r}).touch()\n")
    rewritten(home.parent / "own_law" / "pid_plain.py", ("SOURCE = ", "import beside\n\nSOURCE = "))
    study = own_study(home)
    with Folder.create(tmp_path / "results") as folder:
        freeze(folder, study.kind, home, study.content, study.digest(), study.generations)
    marker.unlink()
    forget()
    return Recorded(tmp_path / "results", tmp_path / "results" / "inputs" / "own_law.toml", marker)


def test_a_run_keeps_its_code_with_what_it_imports(recorded: Recorded) -> None:
    kept = {path.name for path in (recorded.path / "inputs").iterdir()}
    assert kept == {"own_law.toml", "pid_plain.py", "beside.py", "mae.py", "sway.py", "circle.py"}


@pytest.mark.parametrize("command", ["resume", "verify"])
def test_a_results_folder_runs_no_code_that_nobody_named(command: str, recorded: Recorded) -> None:
    with pytest.raises(UnnamedCodeError, match=r"runs only where you name it: look at it, then add --code "):
        getattr(tuner, command)(recorded.path)
    with pytest.raises(UnnamedCodeError):
        tuner.load_study(recorded.study)
    assert not recorded.marker.exists()


def test_what_the_user_names_is_what_its_copy_runs_as(home: Path, recorded: Recorded) -> None:
    use_named(home)
    recorded.marker.unlink()
    assert own_study(recorded.study).digest() == json.loads((recorded.path / "run.json").read_text())["digest"]
    assert not recorded.marker.exists(), "the copy is the same code and did not run again"


def test_a_file_that_has_changed_since_is_refused(home: Path, recorded: Recorded) -> None:
    with (home.parent / "own_law" / "pid_plain.py").open("a") as file:
        file.write("# changed\n")
    use_named(home)
    with pytest.raises(UnnamedCodeError, match="has changed since; put it back, or name the copy with --code"):
        own_study(recorded.study)


def test_a_folder_cannot_have_a_study_elsewhere_read(recorded: Recorded) -> None:
    record = json.loads((recorded.path / "run.json").read_text())
    for study in ("/etc/evil.toml", "../own_law.toml", "inputs/../../own_law.toml"):
        (recorded.path / "run.json").write_text(json.dumps({**record, "study": study}))
        with pytest.raises(tuner.StoreError, match="run.json is damaged"):
            tuner.verify(recorded.path)
    assert not recorded.marker.exists()


def test_gains_name_the_code_of_their_law(home: Path, tmp_path: Path) -> None:
    study = own_study(home)
    tuner.default_gains("pid_plain").write(tmp_path / "gains.json")
    code = json.loads((tmp_path / "gains.json").read_text())["controller"]["code"]
    assert code == {"attitude": {"file": "pid_plain.py", "digest": study.own_code["law"]["pid_plain"]}}
    assert examine(tmp_path / "gains.json").problems == []
    forget()
    assert "name the file with --code pid_plain.py" in str(examine(tmp_path / "gains.json").problems[0])
    with (home.parent / "own_law" / "pid_plain.py").open("a") as file:
        file.write("# changed\n")
    own_study(home)
    assert "name the file of then, or tune again" in str(examine(tmp_path / "gains.json").problems[0])


def test_workers_are_sent_no_code(home: Path) -> None:
    """They are told which files they must have been given, by name and digest."""
    study = own_study(home)
    sent = pickle.dumps(brief_of(study.system, study.seed, FlightBatch(study.scenarios[0].spec, "search", 4)))
    assert b"def step" not in sent
    brief = pickle.loads(sent)
    assert {entry.file.name for entry in brief.files} == {"pid_plain.py", "sway.py", "circle.py"}
    assert system_of(brief).laws["attitude"].name == "pid_plain"
    forget()
    with pytest.raises(InputError, match=r"has not been given pid_plain.py \(digest .*\), which is never sent"):
        system_of(pickle.loads(sent))


@dataclass(frozen=True)
class Distribution:
    """A package, as importlib tells of one."""

    name: str = "my-laws"
    version: str = "1.2"


@dataclass(frozen=True)
class EntryPoint:
    """What importlib.metadata tells of an entry point."""

    module: str
    attr: str
    group: str = "gainproof.laws"
    name: str = "packaged"
    dist: Distribution = Distribution()

    @property
    def value(self) -> str:
        """As in pyproject.toml."""
        return f"{self.module}:{self.attr}"

    def load(self) -> Any:
        """Import it."""
        return getattr(__import__(self.module), self.attr)


def test_a_package_offers_a_law_by_an_entry_point(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    edited(LAW, tmp_path, ('name="pid_plain"', 'name="packaged"'), name="my_packaged_law.py")
    monkeypatch.syspath_prepend(str(tmp_path))
    asked: list[str] = []

    def entry_points(group: str) -> list[EntryPoint]:
        asked.append(group)
        return [EntryPoint("my_packaged_law", "LAW")] if group == "gainproof.laws" else []

    monkeypatch.setattr("importlib.metadata.entry_points", entry_points)
    registry = Registry("law", lambda entry: entry.name, LAWS.values())
    assert registry.find("pid").name == "pid" and asked == [], "what is bundled asks no package"
    found = registry.find("packaged")
    assert found.origin is not None and found.origin.place == "my-laws 1.2" and found.origin.packaged
    with pytest.raises(InputError, match="unknown law 'pakcaged'; did you mean 'packaged'"):
        registry.find("pakcaged")
    assert asked == ["gainproof.laws"]


def test_an_entry_point_that_cannot_be_loaded_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.metadata.entry_points", lambda group: [EntryPoint("no_such_module", "LAW")])
    with pytest.raises(
        InputError, match="gainproof.laws: the entry point packaged = no_such_module:LAW cannot be loaded"
    ):
        Registry("law", lambda entry: entry.name, ()).find("packaged")


def test_the_option_may_stand_anywhere() -> None:
    asked = with_code_first(["resume", "results", "--code", "a.py", "--budget", "3", "--code=b.py"])
    assert asked == ["--code", "a.py", "--code=b.py", "resume", "results", "--budget", "3"]
    assert with_code_first(["resume", "--code"]) == ["--code", "resume"]


def test_check_tells_what_a_file_breaks(tmp_path: Path) -> None:
    assert tuner.check(LAW).content["breaches"] == [] and not tuner.check(LAW).hopeless
    file = edited(LAW, tmp_path, ("error, rate =", "if measured.rate > 1.0:\n        pass\n    error, rate ="))
    found = tuner.check(file)
    (breach,) = found.content["breaches"]
    assert found.hopeless and found.kind == "law"
    assert breach["place"] == f"{file}:{line_of(file, 'if measured')}" and breach["part"] == "step"


def test_an_error_of_the_users_code_is_one_line_with_its_place(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    file = edited(METRIC, tmp_path, ("METRIC = ", "def value(view):\n    return view.missing\n\n\nMETRIC = "))
    value = own_code.run_own_code(file).names["value"]
    monkeypatch.setattr("sys.argv", ["tuner"])
    assert guarded(lambda: value(object())) == 2
    told = capsys.readouterr().err
    assert told.startswith(f"Error: {file}:{line_of(file, 'view.missing')}: AttributeError") and told.count("\n") == 1
    monkeypatch.setattr("sys.argv", ["tuner", "--debug"])
    assert guarded(lambda: value(object())) == 2
    told = capsys.readouterr().err
    assert "Traceback" in told and "AttributeError" in told


def test_the_documentation_shows_the_shipped_files() -> None:
    pages = {name: (SHIPPED.parent / "docs" / "how_to" / f"add_a_{name}.md").read_text() for name in ("law", "metric")}
    assert f"```python\n{LAW.read_text()}```" in pages["law"]
    assert f"```python\n{METRIC.read_text()}```" in pages["metric"]


def test_the_shipped_files_are_the_studys(home: Path) -> None:
    named = {file for table in ("law", "metric", "reference") for file in getattr(own_study(home).table, table).files}
    assert named == {f"own_law/{file.name}" for file in (LAW, METRIC, SWAY, REFERENCE)}


def test_a_study_of_a_plant_refuses_a_metric_that_reads_a_quadrotor(tmp_path: Path) -> None:
    shutil.copy(SHIPPED / "dc_motor.py", tmp_path)
    edited(
        SWAY,
        tmp_path,
        ('"axis"', '"flight"'),
        ("start(sample, target)", "start(sample, targets)"),
        ("update(state, sample, target, t, h)", "update(state, sample, targets, h)"),
        ("return Sway(sample.actual, 0.0)", "return Sway(sample.roll.actual, 0.0)"),
        ("bound=lambda view: 2.0 * view.limit", "bound=lambda view: 7.0"),
        ("return Sway(sample.actual, state", "return Sway(sample.roll.actual, state"),
        ("absolute(sample.actual", "absolute(sample.roll.actual"),
        ('unit="{}"', 'unit="1"'),
    )
    changes = (("[plant]", '[metric]\nfile = "sway.py"\n\n[plant]'), ('metric = "travel"', 'metric = "sway"'))
    study = edited(SHIPPED / "dc_motor.toml", tmp_path, *changes)
    with pytest.raises(
        InputError, match="given 'sway', which reads 'roll' of a flight; this system has time, angle"
    ) as caught:
        load_gains_study(study, "test")
    assert caught.value.key == "metric" and caught.value.file == str(study)
