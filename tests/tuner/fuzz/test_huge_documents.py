"""JSON that is nested without end, or larger than any document, is one line of error in little memory and time."""

import resource
import shutil
import subprocess
import sys

import pytest

from plant.input_files import MAX_VALUES, parse_json
from tests.tuner.extensions.trials.bench import bowls
from tests.tuner.in_process import tuner as in_this_process
from tuner.extensions.trials.asking import MAX_REASONS

DEEP = '{"kind": "tuning", "format": ' + "[" * 100_000 + "]" * 100_000 + "}"
DEEP_STUDY = "a = " + "[" * 100_000 + "]" * 100_000
WIDE = '{"format": "gainproof-run", "kind": "tuning", "values": [' + ",".join(["{}"] * (MAX_VALUES + 1)) + "]}"
COMMANDS = {
    "show": ("RESULTS",), "report": ("RESULTS",), "resume": ("RESULTS",), "verify": ("RESULTS",),
    "rejudge": ("RESULTS", "--out", "new"), "compare": ("RESULTS", "RESULTS"), "confirm": ("RESULTS", "--firmware", "betaflight", "--binary", "JSON"),
    "sensitivity": ("JSON",), "validate": ("JSON",), "margins": ("JSON",), "theory": ("JSON",), "fly": ("JSON",),
    "cost": ("JSON",), "export": ("JSON", "--to", "c99"), "approach": ("JSON", "JSON"),
    "design": ("TOML",), "check": ("TOML",), "plan": ("TOML",), "tell": ("RESULTS", "JSON"), "ask": ("TOML",),
}  # fmt: skip


@pytest.fixture(scope="module", params=["deep", "wide"])
def spoiled(request, small_run, tmp_path_factory):
    """A folder of a run whose documents are all such texts, and files of its like."""
    text, home = {"deep": DEEP, "wide": WIDE}[request.param], tmp_path_factory.mktemp(request.param)
    shutil.copytree(small_run[1], home / "r")
    for file in (home / "r").glob("*.json"):
        file.write_text(text)
    (home / "a.json").write_text(text)
    (home / "a.toml").write_text(DEEP_STUDY)
    return home


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_refuses_it_in_one_line(command, spoiled, monkeypatch, capsys):
    monkeypatch.chdir(spoiled)
    given = {"RESULTS": "r", "JSON": "a.json", "TOML": "a.toml"}
    code, _, err = in_this_process(monkeypatch, capsys, command, *[given.get(word, word) for word in COMMANDS[command]])
    assert code == 2 and err.count("\n") == 1 and err.startswith("Error: "), err[-2000:]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "part"),
    [("run.json", '{"a":1},'), ("summary.json", '"\\u0001",'), ("summary.json", "[],"), ("run.json", "1e5,")],
)
def test_a_huge_document_takes_little_memory_and_time(name, part, small_run, tmp_path):
    """60 MB of such took 7.7 GB and 100 s."""
    results = shutil.copytree(small_run[1], tmp_path / "r")
    (results / name).write_text('{"constraints": [' + part * (60_000_000 // len(part)) + "0]}")
    limited = 2_500_000_000
    code = "from tuner.__main__ import run; run()"
    done = subprocess.run(
        [sys.executable, "-c", code, "resume" if name == "run.json" else "show", results],
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_DATA, (limited, limited)),
    )
    assert (done.returncode, done.stderr.count("\n")) == (2, 1) and name in done.stderr, done.stderr[-1000:]


def test_a_document_of_the_most_values_is_read_and_one_of_more_is_not():
    assert len(parse_json("[" + "0," * (MAX_VALUES - 2) + "0]")) == MAX_VALUES - 1
    with pytest.raises(ValueError, match="values"):
        parse_json("[" + "0," * MAX_VALUES + "0]")


def test_many_bad_lines_are_counted_and_some_are_told(tmp_path, monkeypatch, capsys):
    study = bowls(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert in_this_process(monkeypatch, capsys, "ask", study.path, "--out", "r")[0] == 0
    (tmp_path / "lines").write_text("x\n" * 20_000)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    code, _, err = in_this_process(monkeypatch, capsys, "tell", "r", tmp_path / "lines")
    assert code == 2 and err.count("Refused: ") == MAX_REASONS and "20000 rejected" in err
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 40_000, "kB"
