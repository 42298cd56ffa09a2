"""A program that makes trials on its standard input and output: one that works, and those that end, hang or talk nonsense."""

import sys
from shlex import quote

import pytest

from plant.errors import InputError
from tests.tuner.extensions.trials.bench import bowls, concluded, content, made
from tuner.api.results import TuningResults, open_results
from tuner.extensions.trials.api import ask
from tuner.extensions.trials.program import TrialProcess
from tuner.extensions.trials.record import TrialRecord
from tuner.extensions.trials.run import TrialRun

WORKS = """
import json, sys, time, os
for count, line in enumerate(sys.stdin):
    trial = json.loads(line)
    x, y = trial["variables"]["x"], trial["variables"]["y"]
    {before}
    print(json.dumps({{**trial, "metrics": {{"left": x**2 + y**2, "right": (x - 1.0)**2 + y**2}}}}), flush=True)
"""


@pytest.fixture(autouse=True)
def undrawn_page(monkeypatch):
    """Leave report and figures out, which take most of the time of a run."""
    monkeypatch.setattr(TrialRun, "draw", classmethod(lambda cls, path, watcher: None))


def command(tmp_path, before="pass", text=WORKS):
    """Return the command line of a program, with something that it does before an answer."""
    file = tmp_path / "program.py"
    file.write_text(text.format(before=before) if text is WORKS else text)
    return f"{quote(sys.executable)} {quote(str(file))}"


def test_a_program_gives_the_same_run_as_lines_that_are_told_and_as_a_function(tmp_path):
    study = bowls(tmp_path)
    assert ask(study, tmp_path / "run", command=command(tmp_path)).is_concluded
    assert ask(study, tmp_path / "function", make=made).is_concluded
    concluded(study, tmp_path / "told")
    assert content(tmp_path / "run") == content(tmp_path / "told") == content(tmp_path / "function")


@pytest.mark.slow
def test_a_program_that_ends_or_hangs_costs_the_trial_that_it_was_at(tmp_path):
    study, out = bowls(tmp_path), tmp_path / "out"
    before = 'if trial["id"].startswith("p0003-search"): sys.exit(3)\n    if trial["id"] == "p0004-search-001": time.sleep(60)'
    assert ask(study, out, command=command(tmp_path, before), timeout=4.0).is_concluded
    told = TrialRecord(out).answers
    failed = {name: entry.reason for name, entry in told.items() if entry.failed}
    assert failed == {
        "p0003-search-000": "the program ended with exit code 3",
        "p0003-search-001": "the program ended with exit code 3",
        "p0004-search-001": "the program gave no answer within 4 s",
    }
    assert open_results(out, kind=TuningResults).candidates.loc[3, "objective:mean(left)"] == 40.0


@pytest.mark.parametrize(
    ("text", "timeout", "said"),
    [
        ("import sys; sys.exit(4)", 30.0, "ended with exit code 4 before it answered anything"),
        ("import time; time.sleep(60)", 0.5, "gave no answer within 0.5 s before it answered anything"),
        ("print('hello', flush=True); input(); input()", 30.0, "what the program printed: 'hello' is not JSON"),
        ("import os; os.kill(os.getpid(), 9)", 30.0, "was ended by SIGKILL before it answered anything"),
    ],
)
def test_a_program_that_never_answers_stops_the_run_and_nothing_counts_as_failed(tmp_path, text, timeout, said):
    study, out = bowls(tmp_path), tmp_path / "out"
    with pytest.raises(InputError, match=said):
        ask(study, out, command=command(tmp_path, text=text), timeout=timeout)
    assert TrialRecord(out).answers == {}
    assert ask(study, out, command=command(tmp_path)).is_concluded


@pytest.mark.parametrize(
    ("given", "said"),
    [("", "empty command"), ("a 'b", "write a command line"), ("no-such-program", "cannot be started")],
)
def test_a_command_that_is_none_is_told(tmp_path, given, said):
    with pytest.raises(InputError, match=said):
        ask(bowls(tmp_path), tmp_path / "out", command=given)


def test_a_program_is_ended_with_all_that_it_started(tmp_path):
    mark = tmp_path / "ended"
    text = f"import atexit, sys\natexit.register(lambda: open({str(mark)!r}, 'w').close())\nfor line in sys.stdin: pass"
    program = TrialProcess(command(tmp_path, text=text))
    program._started()
    program.__exit__(None, None, None)
    # The end of its input lets it end by itself.
    assert mark.exists()


@pytest.mark.parametrize(("number", "name"), [(9, "SIGKILL"), (35, "signal 35")])
def test_a_program_that_a_signal_ends_is_said_by_name_or_number(tmp_path, number, name):
    """Signals from 35 on have no name in Python."""
    study, out = bowls(tmp_path), tmp_path / "out"
    before = f'if trial["id"] == "p0003-search-000": os.kill(os.getpid(), {number}); time.sleep(60)'
    assert ask(study, out, command=command(tmp_path, before)).is_concluded
    assert TrialRecord(out).answers["p0003-search-000"].reason == f"the program was ended by {name}"


def test_python_is_the_interpreter_of_the_tool_on_a_machine_that_has_none_of_that_name(tmp_path, monkeypatch):
    """Debian has `python3` alone unless an environment is active."""
    monkeypatch.setenv("PATH", str(tmp_path))
    mark = tmp_path / "mark"
    program = TrialProcess(f"python -c \"import sys; open('{mark}', 'w').write(sys.executable)\"")
    program._started()
    program.__exit__(None, None, None)
    assert mark.read_text() == sys.executable
