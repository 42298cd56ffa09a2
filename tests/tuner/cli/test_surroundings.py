"""Terminals and names that are odd: no columns, no output, ASCII alone, study names that no results folder can hold."""

import json
import os
import subprocess
import sys

import pytest

from tests.tuner.conftest import QUICKSTART

CODE = "from tuner.__main__ import run; run()"
# Each command line of a list in a process of its own, which finds the tool imported in the surroundings of all.
EACH = """
import json, os, sys
import tuner.cli.main
from tuner.__main__ import run

for number, words in enumerate(json.loads(sys.argv[1])):
    child = os.fork()
    if not child:
        for stream in (1, 2):
            os.dup2(os.open(f"{number}.{stream}", os.O_CREAT | os.O_WRONLY), stream)
        sys.argv[1:] = words
        run()
    open(f"{number}.code", "w").write(str(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])))
"""
COMMANDS = {
    "list": ("list", "laws"),
    "help": ("run", "--help"),
    "show": ("show", "RESULTS"),
    "check": ("check", "quickstart", "--set", "margin=[]"),
}
SURROUNDINGS = {
    "one column": {"COLUMNS": "1"},
    "three columns": {"COLUMNS": "3"},
    "ASCII alone": {"PYTHONIOENCODING": "ascii"},
    "plain locale": {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
}


def ended(*words, surroundings=None, closed=()):
    """Run a command as a process of its own; closed: numbers of streams that it is started without."""
    return subprocess.run(
        [sys.executable, "-c", CODE, *map(str, words)],
        capture_output=True,
        check=False,
        timeout=120,
        env={**os.environ, **(surroundings or {})},
        preexec_fn=lambda: [os.close(number) for number in closed],
    )


@pytest.mark.parametrize("where", SURROUNDINGS)
def test_every_terminal_will_do(where, small_run, tmp_path):
    lines = [[str(small_run[1]) if word == "RESULTS" else word for word in words] for words in COMMANDS.values()]
    world = {**os.environ, **SURROUNDINGS[where]}
    subprocess.run([sys.executable, "-c", EACH, json.dumps(lines)], check=True, timeout=120, env=world, cwd=tmp_path)
    for number, words in enumerate(lines):
        code, out, err = ((tmp_path / f"{number}.{part}").read_bytes() for part in ("code", "1", "2"))
        assert (code, err) == (b"0", b"") and out, words


@pytest.mark.parametrize("closed", [(1,), (2,), (0, 1, 2)])
@pytest.mark.parametrize(("words", "code"), [(("list", "laws"), 0), (("show", "nowhere"), 2)])
def test_closed_streams_change_no_exit_code(words, code, closed):
    done = ended(*words, closed=closed)
    assert done.returncode == code and b"Traceback" not in done.stderr
    assert code == 0 or 2 in closed or done.stderr.count(b"\n") == 1


def test_a_file_never_stands_in_the_place_of_a_closed_stream(tmp_path):
    """Else what is printed would go into it."""
    done = ended("new", tmp_path / "first", closed=(0, 1, 2))
    text = (tmp_path / "first.toml").read_text()
    assert done.returncode == 0 and text.startswith("# A tuning study.") and "Wrote" not in text


@pytest.mark.parametrize("name", ["a\\b.toml", "a\nb.toml", "a\x1b[2Jb.toml"])
@pytest.mark.parametrize("command", ["check", "run", "new"])
def test_a_name_that_no_results_folder_can_hold_is_refused_in_one_line(command, name, tmp_path, monkeypatch, tuner):
    monkeypatch.chdir(tmp_path)
    if command != "new":
        (tmp_path / name).write_bytes(QUICKSTART.read_bytes())
    done = tuner(command, name)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and "rename the file" in done.stderr, done.stderr
    assert not (tmp_path / "results").exists()


@pytest.mark.parametrize("command", ["check", "run", "new"])
def test_a_name_that_is_no_text_is_refused_in_one_line(command, tmp_path, monkeypatch):
    """In a process of its own, whose standard error has to take such a name."""
    monkeypatch.chdir(tmp_path)
    name = os.fsdecode(b"a\xff.toml")
    if command != "new":
        (tmp_path / name).write_bytes(QUICKSTART.read_bytes())
    done = ended(command, name)
    assert done.returncode == 2 and done.stderr.count(b"\n") == 1 and b"rename the file" in done.stderr, done.stderr
    assert not (tmp_path / "results").exists()
