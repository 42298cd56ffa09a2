"""The examples of docs/ask_and_tell.md make their trials in Gymnasium and RotorPy, and the commands of the page do what it says."""

import json
import subprocess
from pathlib import Path
from shlex import quote

import pytest

from tests.clients import client
from tests.tuner.extensions.trials.bench import bowls, line, made
from tests.tuner.in_process import called
from tuner.api.results import TuningResults, open_results
from tuner.experiments.planning.preview import preview
from tuner.extensions.trials.api import ask
from tuner.extensions.trials.record import RESULTS_FILE, TrialRecord
from tuner.extensions.trials.run import TrialRun
from tuner.study.kinds import load_any

EXAMPLES = Path(__file__).parents[4] / "docs" / "ask_and_tell"
FEW = {
    "trials": {"search": 2, "held_out": 4},
    "search": {"algorithm": "random", "population": 8, "generations": 2},
}


@pytest.fixture
def undrawn_page(monkeypatch):
    """Leave report and figures out, which take most of the time of a run."""
    monkeypatch.setattr(TrialRun, "draw", classmethod(lambda cls, path, watcher: None))


@pytest.mark.parametrize("name", ["pendulum", "rotorpy_hover"])
def test_the_studies_of_the_examples_are_read_and_ask_for_some_hundred_trials(name):
    study = load_any(EXAMPLES / f"{name}.toml")
    assert 100 < preview(study).content()["trials_at_most"] < 5000


def test_gymnasiums_pendulum_is_tuned(tmp_path, undrawn_page):
    python, out = client("rotorpy"), tmp_path / "out"
    study = load_any(EXAMPLES / "pendulum.toml", FEW)
    command = f"{quote(python)} {quote(str(EXAMPLES / 'pendulum.py'))}"
    assert ask(study, out, command=command, timeout=120.0).is_concluded
    results = open_results(out, kind=TuningResults)
    assert results.feasible
    # A pendulum that is let go falls: of the widest ranges some laws lose it, and no lost one is recommended.
    assert results.document.compared[-1].tuned.value == 0.0
    told = TrialRecord(out).answers
    assert told["p0000-search-000"].metrics != told["p0000-search-001"].metrics


def test_rotorpys_own_law_makes_trials_that_the_seed_alone_decides(tmp_path):
    python = client("rotorpy")
    study = load_any(EXAMPLES / "rotorpy_hover.toml", FEW)
    trials = ask(study, tmp_path / "out").trials[:2]
    file = EXAMPLES / "rotorpy_hover.py"
    lines = [json.dumps(trial.content()) for trial in (*trials, trials[0])]
    done = subprocess.run([python, str(file)], input="\n".join(lines), capture_output=True, text=True, timeout=300)
    first, other, again = [json.loads(entry) for entry in done.stdout.splitlines()]
    assert first == again
    assert first["metrics"] != other["metrics"]
    assert all(0.0 < entry["metrics"]["error"] < 3.0 for entry in (first, other))


def test_the_commands_print_trials_take_answers_and_say_what_comes_next(tmp_path):
    bowls(tmp_path)
    study, out = tmp_path / "bowls.toml", tmp_path / "out"
    code, said, told = called("ask", study, "--out", out, "--count", 3)
    assert code == 0
    assert [json.loads(entry)["id"] for entry in said.splitlines()] == [
        "p0000-search-000",
        "p0000-search-001",
        "p0001-search-000",
    ]
    assert told == f"16 trials pending; submit the results with `tuner tell {out}`, then run `tuner ask` again.\n"
    assert called("ask", study, "--out", out, "--count", 3)[1] == said
    answers = tmp_path / "answers.jsonl"
    given = [line(json.loads(entry), made) for entry in said.splitlines()]
    answers.write_text("\n".join([*given, "nonsense", ""]))
    code, said, told = called("tell", out, answers)
    assert (code, said) == (2, "")
    assert told.splitlines()[0].startswith(f"Refused: {answers}, line 4: 'nonsense' is not JSON; each line is")
    assert told.splitlines()[1] == "Lines: 3 accepted, 0 duplicate, 1 rejected. 13 trials pending."
    assert len((out / RESULTS_FILE).read_text().splitlines()) == 3
    code, said, _ = called("show", out)
    assert code == 0
    assert f"tuner ask {out}/study.toml --out {out}" in said.replace("\n", " ")
    code, _, told = called("tell", out, tmp_path / "nowhere.jsonl")
    assert code == 2
    assert told.startswith(f"Error: {tmp_path / 'nowhere.jsonl'}: cannot be read")
    code, _, told = called("ask", "quickstart")
    assert code == 2
    assert "this study flies by itself: `tuner run`" in told


def test_a_concluded_run_is_told_and_drawn_again(tmp_path):
    study = bowls(tmp_path)
    out = ask(study, tmp_path / "out", make=made).path
    code, said, told = called("ask", tmp_path / "bowls.toml", "--out", out)
    assert (code, said) == (0, "")
    assert told.startswith("All results are in")
    code, said, _ = called("show", out)
    assert code == 0
    assert "2 variables, seed 7; random tried 16 candidates" in said
    assert called("report", out)[0] == 0
    assert called("check", tmp_path / "bowls.toml")[0] == 0
    assert "Intact" in called("verify", out)[1]
