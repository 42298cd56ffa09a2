"""A run for a firmware ends with the opinion on its gains against the present ones; no other run does."""

import json
from pathlib import Path
from shutil import copytree
from types import SimpleNamespace
from typing import Any

import pytest

from plant.errors import InputError
from tests.tuner.conftest import QUICKSTART
from tuner.api import opinion as ending
from tuner.api.gains import gains_of
from tuner.api.results import TuningResults, open_results
from tuner.cli.printing import RunAnswer
from tuner.documents.assessment import AssessmentDocument
from tuner.experiments.again.verify import verify
from tuner.extensions.judge.api import Assessment
from tuner.search.watcher import Watcher
from tuner.study.build import load_study

FIRMWARES = {"px4": "px4", "ardupilot": "ardupilot", "betaflight": "betaflight", "crazyflie": "crazyflie_firmware"}


def results_of(study, tuned="p0001", feasible=True, folder="run") -> Any:
    results = object.__new__(TuningResults)
    results.__dict__.update(
        folder=Path(folder), document=SimpleNamespace(tuned=tuned, recommends=feasible), study=study
    )
    return results


def an_opinion() -> AssessmentDocument:
    """Return an opinion without loops, rules and changed gains."""
    file = {"file": "present.params", "source": "px4", "version": "1.16", "sha256": "0"}
    lost = {"events": 0, "flights": 16, "upper": 0.2}
    flights = {"metric": "rms.tilt", "definition": "error", "unit": "rad", "before": 0.02, "after": 0.01}
    content = {
        "format": "gainproof-assessment", "version": "0.1", "verdict": "better", "comparison": "better",
        "sentence": "Better: rms.tilt -50 % [-51, -49].", "reasons": [], "unmodeled": [], "unmodeled_changes": [],
        "guessed": None, "after": {**file, "file": "gains.json"}, "before": file,
        "airframe": {"name": "f450", "title": "F450", "is_known": True, "ranges": "given"},
        "changes": [], "loops": [], "rules": [], "scenario": "small steps", "seed": 1, "flights": 16,
        "gyro_noise": {"value": 1e-4, "unit": "rad/s"},
        "metrics": [{**flights, "difference": {"value": -0.5, "low": -0.51, "high": -0.49}, "verdict": "better"}],
        "lost_after": lost, "lost_before": lost, "rollback": None, "not_restored": [], "seconds": {},
    }  # fmt: skip
    return AssessmentDocument.parse(json.dumps(content))


@pytest.fixture
def study(tmp_path):
    path = QUICKSTART.parent / "px4.toml"
    plain = load_study(path)
    gains_of(plain.controller(plain.default_row), {}).write(tmp_path / "present.json")
    return load_study(path, {"controller.default": str(tmp_path / "present.json")})


def test_the_opinion_is_on_the_gains_of_the_run_against_the_file_of_the_study(study, tmp_path, monkeypatch, capsys):
    asked = []

    def judge(after, before, **options):
        asked.append((after, before, options["threads"]))
        document = SimpleNamespace(
            before=SimpleNamespace(file="present.json"),
            sentence="Worse: rms.tilt 12 % [11, 13].",
            verdict="worse",
        )
        return SimpleNamespace(document=document, passed=False)

    monkeypatch.setattr("tuner.extensions.judge.present.judge", judge)
    results = results_of(study)
    monkeypatch.setattr(ending, "add_opinion", lambda results, opinion: setattr(results, "opinion", opinion))
    ending.end_with_opinion(results, 2, Watcher())
    assert asked == [(Path("run/gains.json"), tmp_path / "present.json", 2)]
    answered = RunAnswer(False)
    answered._is_printed = True
    answered.end(results, 0)
    text = " ".join(capsys.readouterr().out.split())
    assert (
        text
        == "Against the present gains, present.json, in the flights of `tuner judge`: Worse: rms.tilt 12 % [11, 13]."
    )


def test_gains_that_cannot_be_compared_leave_the_run_as_it_is(study, monkeypatch):
    def judge(*_, **__):
        raise InputError("flies another airframe")

    class Heard(Watcher):
        def on_message(self, text):
            messages.append(text)

    messages = []
    monkeypatch.setattr("tuner.extensions.judge.present.judge", judge)
    results = results_of(study)
    ending.end_with_opinion(results, None, Heard())
    assert results.opinion is None
    assert messages == ["Not judged against the present gains: flies another airframe"]


def test_without_present_gains_or_new_ones_nothing_is_compared(study):
    assert ending.present_gains(results_of(study)) is not None
    assert ending.present_gains(results_of(load_study(QUICKSTART.parent / "px4.toml"))) is None
    assert ending.present_gains(results_of(load_study(QUICKSTART))) is None
    assert ending.present_gains(results_of(None)) is None
    assert ending.present_gains(results_of(study, tuned="default")) is None
    assert ending.present_gains(results_of(study, feasible=False)) is None


def test_without_an_extension_that_judges_a_run_ends_without_an_opinion(study, monkeypatch):
    monkeypatch.setattr(ending, "added", lambda part: {})
    results = results_of(study)
    ending.end_with_opinion(results, None, Watcher())
    assert results.opinion is None


@pytest.mark.parametrize("name", FIRMWARES.values(), ids=FIRMWARES)
def test_a_study_of_a_firmware_judges_the_attitude_that_its_rate_loops_hold(name):
    study = load_study(QUICKSTART.parent / f"{name}.toml")
    judged = [*study.objectives, *[entry.objective for entry in study.constraints if not entry.floor]]
    assert any(entry.metric.text == "rms.tilt" and entry.scenario in (None, "small steps") for entry in judged)


def test_a_filter_that_the_vehicle_flies_without_is_in_no_search_and_not_refused(tmp_path):
    path = QUICKSTART.parent / "ardupilot.toml"
    plain = load_study(path)
    row, (column,) = (
        plain.default_row.copy(),
        [gain.column for gain in plain.system.gains if gain.address == "yaw.d_cutoff"],
    )
    row[column] = 0.0
    gains_of(plain.controller(row), {}).write(tmp_path / "present.json")
    settings = {"controller.default": str(tmp_path / "present.json")}
    study = load_study(path, settings)
    assert study.default_row[column] == 0.0
    for typed, words in (
        ({**settings, "gains": {"yaw.d_cutoff": 0.5}}, "given 0.5 Hz"),
        ({"gains": {"yaw.d_cutoff": 0.0}}, "given 0 Hz"),
    ):
        with pytest.raises(InputError, match=words):
            load_study(path, typed)


def test_an_opinion_joins_the_document_the_page_and_the_terminal_and_leaves_a_whole_folder(small_run, tmp_path, tuner):
    folder = tmp_path / "run"
    copytree(small_run[1], folder)
    document = an_opinion()
    before = document.before
    assert before is not None
    ending.add_opinion(TuningResults(folder), Assessment(document))

    assert json.loads(open_results(folder).json)["opinion"] == document.content()
    assert json.loads(tuner("show", folder, "--json").stdout)["opinion"] == document.content()
    said = f"Against the present gains, {before.file}"
    assert said in " ".join(tuner("show", folder).stdout.split())
    page = (folder / "report.html").read_text()
    assert said in page and page.index("Against the present gains</h2>") < page.index("<h3>Flights</h3>")
    assert document.metrics and all(row.metric in page for row in document.metrics)
    assert verify(folder, 1, None, Watcher()).same
    # It is one of the files of a complete folder, so damage to it is noticed.
    summary = folder / "summary.json"
    summary.write_text(
        summary.read_text().replace(document.verdict, "better" if document.verdict != "better" else "worse")
    )
    assert not verify(folder, 1, None, Watcher()).same


def test_json_waits_for_the_opinion_and_a_person_does_not(small_run, capsys):
    RunAnswer(True, has_opinion=True).print_folder(small_run[1], None)
    assert capsys.readouterr().out == ""
    RunAnswer(True).print_folder(small_run[1], None)
    assert json.loads(capsys.readouterr().out)["title"]
