"""With no extension installed the core does all that it promises, from a new study to code for a vehicle."""

import json
import subprocess
import sys

import pytest

ALONE = """
import json
import sys

import tuner.extension

tuner.extension.extensions = lambda: {}

from typer.testing import CliRunner

from tuner.cli.main import app

for words in json.loads(sys.argv[1]):
    done = CliRunner().invoke(app, words)
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        print(json.dumps([words, type(done.exception).__name__, str(done.exception)]))
    else:
        print(json.dumps([words, done.exit_code, done.output[-2000:]]))
"""
COMMANDS = [
    ["new", "mine", "--from", "quickstart"], ["list"], ["list", "laws"], ["check", "mine.toml"],
    ["plan", "mine.toml"], ["design", "mine.toml"],
    ["run", "mine.toml", "--set", "search.generations=2", "--set", "search.population=8", "--out", "out"],
    ["resume", "out", "--budget", "3"], ["rejudge", "out", "--out", "judged"], ["verify", "out"], ["show", "out"],
    ["report", "out"], ["compare", "out", "out/gains.json", "--out", "compared"], ["fly", "out/gains.json", "--seeds", "4"],
    ["margins", "out/gains.json"], ["export", "out/gains.json", "--to", "c99", "--flights", "2", "--force"],
    ["validate", "out/gains.json"], ["schema", "summary"], ["bench", "--help"],
]  # fmt: skip
REFUSED = {
    "judge": (["judge", "out/gains.json"], "No such command 'judge'"),
    "target": (["export", "out/gains.json", "--to", "px4"], "unknown target 'px4'"),
    "template": (["new", "extension", "warm"], "no installed extension adds a template"),
    "airframe": (
        ["new", "a", "--mass", "1", "--wheelbase", "0.4", "--propeller", "10x4", "--kv", "900", "--cells", "3"],
        "no installed extension adds",
    ),
    "backend": (["run", "mine.toml", "--backend", "cuda", "--out", "cuda"], "cuda"),
    "cluster": (["run", "mine.toml", "--dask", "local", "--out", "dask"], "dask"),
}


def alone(commands, folder):
    """Run commands in one process without any extension; return exit code, or error, and output of each."""
    run = [sys.executable, "-c", ALONE, json.dumps(commands)]
    done = subprocess.run(run, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


@pytest.mark.slow
def test_every_command_of_the_core_alone_does_its_work(tmp_path):
    answers = alone([*COMMANDS, *[words for words, _ in REFUSED.values()]], tmp_path)
    for words, code, output in answers[: len(COMMANDS)]:
        # A short search may recommend nothing better, and margins of its gains may break a limit: both are answers.
        assert code in ((0, 1) if words[0] in {"margins", "export"} else (0,)), (words, code, output)
    for (words, code, output), (_, said) in zip(answers[len(COMMANDS) :], REFUSED.values(), strict=True):
        assert code != 0 and said in " ".join(str(output).split()), (words, code, output)
    assert (tmp_path / "out" / "report.html").exists() and (tmp_path / "out" / "export" / "c99").is_dir()
