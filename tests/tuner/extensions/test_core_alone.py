"""With no extension installed the core does all that it promises, from a new study to code for a vehicle.

With all but one, and those that require it, the others do theirs.
"""

import json
import subprocess
import sys

import pytest

from tuner.extension import extensions
from tuner.study.files import shipped_studies

RECORDS = extensions()

ALONE = """
import json
import sys

import tuner.extension

records, kept = tuner.extension.extensions(), set(json.loads(sys.argv[2]))
tuner.extension.extensions = lambda: {name: record for name, record in records.items() if name in kept}

from typer.testing import CliRunner

from tuner.cli.main import app

for words in json.loads(sys.argv[1]):
    done = CliRunner().invoke(app, words)
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        print(json.dumps([words, type(done.exception).__name__, str(done.exception)]))
    else:
        print(json.dumps([words, done.exit_code, done.output[-20_000:]]))
"""
COMMANDS = [
    ["new", "mine", "--from", "quickstart"], ["list"], ["list", "laws"], ["check", "mine.toml"],
    ["plan", "mine.toml"], ["design", "mine.toml"],
    ["run", "mine.toml", "--set", "search.generations=2", "--set", "search.population=8", "--out", "out"],
    ["resume", "out", "--budget", "3"], ["rejudge", "out", "--out", "judged"], ["verify", "out"], ["show", "out"],
    ["report", "out"], ["compare", "out", "out/gains.json", "--out", "compared"], ["fly", "out/gains.json", "--seeds", "4"],
    ["margins", "out/gains.json"], ["export", "out/gains.json", "--to", "c99", "--flights", "2", "--force"],
    ["validate", "out/gains.json"], ["schema", "summary"],
]  # fmt: skip
REFUSED = {
    "judge": (
        ["judge", "out/gains.json"],
        "the command 'judge' comes with the extension judge of gainproof, which is not installed",
    ),
    "target": (
        ["export", "out/gains.json", "--to", "px4"],
        "the target 'px4' comes with the extension px4 of gainproof, which is not installed",
    ),
    "template": (["new", "extension", "warm"], "no installed extension adds a template"),
    "airframe": (
        ["new", "a", "--mass", "1", "--wheelbase", "0.4", "--propeller", "10x4", "--kv", "900", "--cells", "3"],
        "no installed extension adds",
    ),
    "backend": (["run", "mine.toml", "--backend", "cuda", "--out", "cuda"], "cuda"),
    "cluster": (["run", "mine.toml", "--dask", "local", "--out", "dask"], "dask"),
}


QUICKSTART = (shipped_studies()["quickstart"]).read_text()
FILES = {
    "trials.toml": 'title = "Elsewhere"\nseed = 1\n[trials]\n',
    "choices.toml": f'{QUICKSTART}\n[choices]\n"controller.attitude" = ["hybrid", "pid"]\n',
    "theory.toml": f'{QUICKSTART}\n[[guarantee]]\ntheorem = "ultimate_error"\naxis = "attitude"\nmax = 1.0\n',
    "cost.toml": f'{QUICKSTART}\n[[cost]]\nquantity = "stack"\nmax = 1e4\n',
    "tails.toml": f'{QUICKSTART}\n[[constraint]]\nmetric = "failure"\nrisk = "probability"\nmax = 1e-4\n',
    "sealed/contest.json": "{}",
    "begun/run.json": '{"kind": "contest"}',
    "asked/run.json": '{"kind": "trials"}',
}
LACKING = [
    (["check", "contest"], "contests"), (["run", "contest"], "contests"), (["plan", "contest"], "contests"),
    (["check", "choices.toml"], "contests"), (["report", "sealed"], "contests"), (["report", "begun"], "contests"),
    (["show", "begun"], "contests"), (["schema", "contest"], "contests"), (["schema", "choices-study"], "contests"),
    (["check", "trials.toml"], "trials"), (["report", "asked"], "trials"), (["check", "theory.toml"], "theory"),
    (["list", "theorems"], "theory"), (["check", "cost.toml"], "processor_cost"), (["check", "tails.toml"], "tails"), (["schema", "tail"], "tails"),
    (["margins", "--law", "adrc", "--certificates"], "certificates"), (["run", "quickstart", "--dask", "local"], "cluster"),
    (["run", "quickstart", "--backend", "cuda"], "cuda"), (["judge", "--help"], "judge"), (["ask", "trials.toml"], "trials"),
    (["bench", "--help"], "bench"),
]  # fmt: skip


@pytest.mark.slow
def test_what_only_a_bundled_extension_reads_is_refused_with_its_name(tmp_path):
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    answers = alone([words for words, _ in LACKING], tmp_path)
    for (words, error, said), (_, name) in zip(answers, LACKING, strict=True):
        assert error == "InputError", (words, error, said)
        named = f"comes with the extension {name} of gainproof, which is not installed; install gainproof with it"
        assert named in said or f"such as {name} of gainproof" in said, (words, said)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted({name.partition("/")[0] for name in FILES})


def alone(commands, folder, kept=()):
    """Run commands in one process with these extensions alone; return exit code, or error, and output of each."""
    run = [sys.executable, "-c", ALONE, json.dumps(commands), json.dumps(sorted(kept))]
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


def those_left(name):
    """Names of the extensions that neither are this one nor require it, in any number of steps."""
    gone = {name}
    while more := {other for other, record in RECORDS.items() if gone & {*record.requires}} - gone:
        gone |= more
    return {*RECORDS} - gone


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(RECORDS))
def test_each_extension_can_be_left_out(tmp_path, name):
    kept = those_left(name)
    commands = [[command, "--help"] for other in kept for command in RECORDS[other].commands]
    lists = [["list"], ["list", "targets"], ["list", "laws"], ["list", "extensions", "--json"]]
    answers = alone([*lists, ["check", "quickstart"], *commands], tmp_path, kept)
    assert [answer for answer in answers if answer[1] != 0] == []
    assert {row["extension"] for row in json.loads(answers[3][2])} == kept
