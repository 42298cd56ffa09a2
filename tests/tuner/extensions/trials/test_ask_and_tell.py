"""Ask and tell: what is asked for, what is told, and a run that is interrupted anywhere and ends with the same bytes."""

import json
import subprocess
import sys
from math import sqrt
from typing import Any

import numpy as np
import pytest

from plant.errors import InputError, StoreError
from tests.tuner.extensions.trials.bench import BOWLS, SAME, TITLE, bowls, concluded, content, line, made, noisy
from tests.tuner.store.faults import AFTER, FULL, Faults
from tuner.api.results import TuningResults, open_results
from tuner.api.run_report import report_run
from tuner.experiments.again.resume import resume
from tuner.experiments.registry import run
from tuner.extensions.trials.asking import ask, tell
from tuner.extensions.trials.record import RESULTS_FILE, TrialRecord
from tuner.extensions.trials.run import TrialRun


@pytest.fixture
def undrawn_page(monkeypatch):
    """Leave report and figures out, which take most of the time of a run."""
    monkeypatch.setattr(TrialRun, "draw", classmethod(lambda cls, path, watcher: None))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A concluded run with its report, and its study."""
    folder = tmp_path_factory.mktemp("trials")
    study = bowls(folder)
    return study, concluded(study, folder / "out", noisy)


def test_the_first_trials_are_those_of_the_default_and_every_candidate_meets_the_same_seeds(tmp_path):
    study = bowls(tmp_path)
    trials = ask(study, tmp_path / "out").trials
    assert len(trials) == 16
    assert trials[0].variables == {"x": 1.5, "y": 0.5}
    seeds = {}
    for trial in trials:
        seeds.setdefault(trial.scenario, set()).add(trial.seed)
    assert {name: len(found) for name, found in seeds.items()} == {"search-000": 1, "search-001": 1}
    assert seeds["search-000"] != seeds["search-001"]
    # The same lines as before, from a run that is looked at again.
    assert ask(study, tmp_path / "out").trials == trials
    # Other root seed, other trials.
    (tmp_path / "other").mkdir()
    other = bowls(tmp_path / "other", {"seed": 8})
    assert ask(other, tmp_path / "other" / "out").trials[0].seed != trials[0].seed


def test_what_is_told_is_asked_for_no_more(tmp_path):
    study, out = bowls(tmp_path), tmp_path / "out"
    trials = ask(study, out).trials
    told = tell(out, [line(trial.content(), made) for trial in trials[:5]], "lines")
    assert (told.n_accepted, told.n_duplicates, told.rejected, told.n_pending) == (5, 0, [], 11)
    assert ask(study, out).trials == trials[5:]
    tell(out, [line(trial.content(), made) for trial in trials[5:]], "lines")
    following = ask(study, out).trials
    assert not {trial.id for trial in following} & {trial.id for trial in trials}


@pytest.mark.slow
def test_the_front_in_closed_form_is_met(tmp_path, undrawn_page):
    """On the front of two bowls around (0, 0) and (1, 0) the square roots of the two values add up to 1.

    The default (1.5, 0.5) has the values 2.5 and 0.5, so the box of the hypervolume ends at 2.75 and 0.55. The area that the
    front dominates in it is the integral of 0.55 - (1 - sqrt f)^2 from where that is 0, and 0.55 (2.75 - 1) beyond f = 1.
    """
    search = {"search": {"algorithm": "gaussian_process", "population": 8, "generations": 8}}
    study, out = bowls(tmp_path, search), tmp_path / "out"
    concluded(study, out)
    results = open_results(out, kind=TuningResults)
    begin = (1.0 - sqrt(0.55)) ** 2
    beyond = [0.55 * f - (f - 4.0 / 3.0 * f**1.5 + f**2 / 2.0) for f in (begin, 1.0)]
    area = beyond[1] - beyond[0] + 0.55 * 1.75
    assert results.document.hypervolume == pytest.approx(area / (2.75 * 0.55), rel=0.01)
    assert results.document.hypervolume <= area / (2.75 * 0.55)
    picked = results.recommended
    assert picked is not None
    assert sqrt(picked["x"] ** 2 + picked["y"] ** 2) + sqrt((picked["x"] - 1) ** 2 + picked["y"] ** 2) < 1.02


def test_a_concluded_folder_is_that_of_a_tuning_run(whole):
    study, out = whole
    results = open_results(out, kind=TuningResults)
    assert results.recommended == {row.name: row.tuned for row in results.document.variables}
    assert results.default == pytest.approx({"x": 1.5, "y": 0.5})
    assert results.gains("default") == results.default
    assert {row.name: row.unit for row in results.document.variables} == {"x": "m", "y": "1"}
    written = json.loads((out / "gains.json").read_text())
    assert {name: entry["value"] for name, entry in written["gains"].items()} == results.recommended
    # Intervals come from the scenarios, which differ.
    row = results.document.compared[0]
    value, low, high = row.tuned.value, row.tuned.low, row.tuned.high
    assert low is not None and value is not None and high is not None and low < value < high
    assert list(results.history.index) == [0, 1]
    page = (out / "report.html").read_text()
    assert "trials run by another program" in page
    for absent in ("Its responses", "Its loops", "The air that was flown", "Airframe"):
        assert absent not in page
    told: Any = report_run(out).document
    assert "airframe" not in told["asked"]
    assert told["commands"] == [f"tuner report {out}"]
    assert ask(study, out).is_concluded


def test_the_values_are_those_that_were_told(whole):
    """The values of candidates in the search are the means of what was told of them, by whoever reads the two records."""
    _, out = whole
    record = TrialRecord(out)
    tried = open_results(out, kind=TuningResults).candidates
    for candidate in (1, 7, 12):
        told = [record.answers[f"p{candidate:04d}-search-{i:03d}"].metrics or {} for i in (0, 1)]
        assert tried.loc[candidate, "objective:mean(left)"] == pytest.approx(np.mean([entry["left"] for entry in told]))


def test_the_order_of_what_is_told_decides_nothing(tmp_path, whole, undrawn_page):
    study, out = whole
    concluded(study, tmp_path / "out", noisy, answered=lambda lines: lines[::-1])
    assert content(tmp_path / "out") == content(out)


def interrupted(study, out, faults):
    """Ask and tell until the run is concluded or interrupted."""
    with faults:
        try:
            concluded(study, out, noisy)
        except (StoreError, KeyboardInterrupt, OSError):
            return
    pytest.fail("nothing went wrong")


@pytest.mark.slow
@pytest.mark.parametrize("kind", [FULL, AFTER])
def test_a_run_that_is_interrupted_anywhere_ends_with_the_same_bytes(tmp_path, whole, undrawn_page, kind):
    study, out = whole
    with Faults(tmp_path) as faults:
        concluded(study, tmp_path / "counted", noisy)
    places = np.unique(np.linspace(1, faults.count, 9).round().astype(int)).tolist()
    for nth in places:
        again = tmp_path / f"{nth}"
        interrupted(study, again, Faults(again, nth, kind))
        before = (again / RESULTS_FILE).read_bytes() if (again / RESULTS_FILE).exists() else b""
        if again.exists() and not (again / "run.json").exists():
            # Killed while the folder was made: the same command begins again.
            assert before == b""
        concluded(study, again, noisy)
        assert content(again) == content(out), (nth, faults.told)
        # Nothing that was told in whole lines is lost.
        assert (again / RESULTS_FILE).read_bytes().startswith(before[: before.rfind(b"\n") + 1])


def test_a_line_that_a_killed_process_left_in_part_is_asked_for_again(tmp_path, whole, undrawn_page):
    study, finished = whole
    out = tmp_path / "out"
    trials = ask(study, out).trials
    tell(out, [line(trial.content(), noisy) for trial in trials[:3]], "lines")
    content_told = (out / RESULTS_FILE).read_bytes()
    for cut in (1, 20, len(content_told) - content_told.rfind(b"\n", 0, -1) - 2):
        (out / RESULTS_FILE).write_bytes(content_told[:-cut])
        assert len(ask(study, out).trials) == 14
    concluded(study, out, noisy)
    assert content(out) == content(finished)


@pytest.mark.slow
def test_a_killed_process_is_followed_by_another(tmp_path, whole, undrawn_page):
    """A process that tells is killed by the system between two lines, whichever it is at."""
    study, finished = whole
    out = tmp_path / "out"
    script = (
        "import os, sys; from pathlib import Path; from tests.tuner.extensions.trials.bench import *; "
        "from tuner.extensions.trials.record import TrialRecord; keep, left = TrialRecord.tell, [21]\n"
        "def tell(self, answer):\n"
        "    left[0] -= 1\n"
        "    if not left[0]: os.kill(os.getpid(), 9)\n"
        "    keep(self, answer)\n"
        "TrialRecord.tell = tell\n"
        "concluded(load_any(Path(sys.argv[1])), Path(sys.argv[2]), noisy)\n"
    )
    killed = subprocess.run([sys.executable, "-c", script, str(study.path), str(out)], capture_output=True, text=True)
    assert killed.returncode == -9, killed.stderr
    assert len(TrialRecord(out).answers) == 20
    concluded(study, out, noisy)
    assert content(out) == content(finished)


def test_a_failed_trial_costs_more_than_any_that_did_not(tmp_path, undrawn_page):
    text = 'title = "Failing"\nseed = 1\n' + (
        "trials = { search = 1, held_out = 2 }\n"
        'variable = [{ name = "x", low = 0.0, high = 1.0, default = 0.25 }]\n'
        'metric = [{ name = "cost", worst = 4.0 }]\nobjective = [{ metric = "cost" }]\n'
        'constraint = [{ metric = "failure", max = 0.0 }]\n'
        'search = { algorithm = "random", population = 8, generations = 1 }\n'
    )
    study, out = bowls(tmp_path, text=text), tmp_path / "out"
    trials = ask(study, out).trials
    lines = [json.dumps({"id": trial.id, "metrics": {"cost": 1.0}}) for trial in trials]
    lines[2] = json.dumps({"id": trials[2].id, "failed": True, "reason": "it\nbroke"})
    lines[3] = json.dumps({"id": trials[3].id, "metrics": {"cost": 1e9}})
    assert tell(out, lines, "lines").rejected == []
    assert TrialRecord(out).answers[trials[2].id].reason == "it\\nbroke"
    concluded(study, out, lambda trial: {"cost": 1.0})
    tried = open_results(out, kind=TuningResults).candidates
    assert tried["objective:mean(cost)"].tolist() == [1.0, 1.0, 8.0, 4.0, 1.0, 1.0, 1.0, 1.0]
    assert tried["feasible"].tolist() == [True, True, False, True, True, True, True, True]


def test_nothing_feasible_is_told_and_not_recommended(tmp_path, undrawn_page):
    study, out = bowls(tmp_path, {"constraint": [{"metric": "left", "max": 0.0}]}), tmp_path / "out"
    concluded(study, out)
    results = open_results(out, kind=TuningResults)
    assert not results.feasible
    assert results.recommended is None
    assert json.loads((out / "infeasible.json").read_text())["feasible"] is False
    assert "mean(left)" in results.document.ending[0] or results.document.ending[0].startswith("Nothing feasible")


def test_another_study_does_not_go_on_with_the_folder(tmp_path):
    study, out = bowls(tmp_path), tmp_path / "out"
    ask(study, out)
    with pytest.raises(StoreError, match="was begun with another study"):
        ask(bowls(tmp_path, {"seed": 8}), out)
    # Texts decide nothing.
    assert ask(bowls(tmp_path, {"title": "The same bowls"}), out).trials


def test_a_folder_of_something_else_is_left_alone(tmp_path):
    study, out = bowls(tmp_path), tmp_path / "out"
    out.mkdir()
    (out / "mine.txt").write_text("mine")
    with pytest.raises(StoreError, match="exists already"):
        ask(study, out)
    with pytest.raises(StoreError, match=r"holds no run\.json"):
        tell(out, [], "lines")
    with pytest.raises(StoreError, match="there is no such results folder"):
        tell(tmp_path / "nowhere", [], "lines")
    assert [entry.name for entry in out.iterdir()] == ["mine.txt"]


def test_what_flies_by_itself_is_told_apart(tmp_path, whole):
    study, out = whole
    with pytest.raises(InputError, match="`tuner ask .*` prints those that are to be made"):
        run(study, tmp_path / "out")
    with pytest.raises(StoreError, match="another program runs the trials of"):
        resume(out)
    with pytest.raises(StoreError, match="was concluded and takes no more trials"):
        tell(out, [], "lines")


def test_a_damaged_line_is_told_with_its_number_and_what_to_do(tmp_path):
    study, out = bowls(tmp_path), tmp_path / "out"
    trials = ask(study, out).trials
    tell(out, [line(trial.content(), made) for trial in trials[:3]], "lines")
    lines = (out / RESULTS_FILE).read_bytes().splitlines(keepends=True)
    (out / RESULTS_FILE).write_bytes(lines[0] + b"garbage\n" + lines[2])
    with pytest.raises(StoreError, match=r"told\.jsonl: line 2 is damaged; take the line out"):
        ask(study, out)
    (out / RESULTS_FILE).write_bytes(lines[0] + lines[2])
    assert trials[1] in ask(study, out).trials


def test_trials_asked_for_otherwise_are_refused(tmp_path):
    study, out = bowls(tmp_path), tmp_path / "out"
    ask(study, out)
    asked = out / "asked.jsonl"
    asked.write_text(asked.read_text().replace('"x": 1.5', '"x": 1.25'))
    with pytest.raises(StoreError, match="the recorded p0000-search-000 has other values"):
        ask(study, out)


def test_the_defaults_trials_have_its_very_values(tmp_path):
    """On a logarithmic scale 0.1 to 10 the default 0.5 comes back from the unit cube as 0.49999999999999994."""
    former, out = "low = -1.0\nhigh = 1.0\ndefault = 0.5", tmp_path / "out"
    logarithmic = 'low = 0.1\nhigh = 10.0\nscale = "log"\ndefault = 0.5'
    assert former in BOWLS
    study = bowls(tmp_path, text=TITLE + BOWLS.replace(former, logarithmic))
    assert ask(study, out).trials[0].variables == {"x": 1.5, "y": 0.5}
    # Runs of former versions hold the other number, and go on.
    asked = out / "asked.jsonl"
    asked.write_text(asked.read_text().replace('"y": 0.5}', '"y": 0.49999999999999994}'))
    assert ask(study, out).trials[0].id == "p0000-search-000"


def test_the_files_compared_here_are_written(whole):
    _, out = whole
    assert set(content(out)) == set(SAME)


@pytest.mark.parametrize("key", ["objective", "constraint"])
def test_a_probability_is_refused(tmp_path, key):
    table = {"metric": "failure", "risk": "probability"} | ({"max": 0.01} if key == "constraint" else {})
    with pytest.raises(InputError, match='for the share of failed trials write risk = "mean"') as caught:
        bowls(tmp_path, {key: [table]})
    assert (caught.value.file, caught.value.key) == (str(tmp_path / "bowls.toml"), f"{key}[0].risk")
