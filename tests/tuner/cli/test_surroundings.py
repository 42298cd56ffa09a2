"""Terminals and names that are odd: no columns, no output, ASCII alone, study names that no results folder can hold."""

import io
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from typer.main import get_group

from plant.errors import InputError
from tests.tuner.conftest import QUICKSTART
from tuner.api.catalogue import listings
from tuner.cli.main import _invoke, app
from tuner.text.errors import CLOSED_PIPE, guarded
from tuner.text.signals import CRASHED

ROOT = Path(__file__).parents[3]

CODE = "from tuner.__main__ import run; run()"
# Each command line of a list in a process of its own, which finds the tool imported in the surroundings of all.
EACH = """
import json, os, sys
import tuner.api.checking, tuner.cli.main, tuner.cli.printers.check
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


@pytest.mark.slow
@pytest.mark.parametrize("where", ["plain locale", "one column", "three columns", "ASCII alone"])
def test_every_terminal_will_do(where, small_run, tmp_path):
    lines = [[str(small_run[1]) if word == "RESULTS" else word for word in words] for words in COMMANDS.values()]
    world = {**os.environ, **SURROUNDINGS[where]}
    subprocess.run([sys.executable, "-c", EACH, json.dumps(lines)], check=True, timeout=120, env=world, cwd=tmp_path)
    for number, words in enumerate(lines):
        code, out, err = ((tmp_path / f"{number}.{part}").read_bytes() for part in ("code", "1", "2"))
        assert (code, err) == (b"0", b"") and out, words


@pytest.mark.parametrize(
    ("words", "code", "closed"),
    [
        (("show", "nowhere"), 2, (0, 1, 2)),
        *[
            pytest.param(words, code, closed, marks=pytest.mark.slow)
            for words, code, closed in (
                (("list", "laws"), 0, (1,)),
                (("show", "nowhere"), 2, (2,)),
                (("list", "laws"), 0, (2,)),
                (("list", "laws"), 0, (0, 1, 2)),
                (("show", "nowhere"), 2, (1,)),
            )
        ],
    ],
)
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


@pytest.mark.parametrize("command", ["new", *(pytest.param(name, marks=pytest.mark.slow) for name in ("check", "run"))])
def test_a_name_that_is_no_text_is_refused_in_one_line(command, tmp_path, monkeypatch):
    """In a process of its own, whose standard error has to take such a name."""
    monkeypatch.chdir(tmp_path)
    name = os.fsdecode(b"a\xff.toml")
    if command != "new":
        (tmp_path / name).write_bytes(QUICKSTART.read_bytes())
    done = ended(command, name)
    assert done.returncode == 2 and done.stderr.count(b"\n") == 1 and b"rename the file" in done.stderr, done.stderr
    assert not (tmp_path / "results").exists()


def printed(monkeypatch, encoding, *words):
    """Run a command in this process on strict streams of an encoding; return its code and what the streams hold."""
    streams = [io.TextIOWrapper(io.BytesIO(), encoding=encoding, errors="strict") for _ in range(2)]
    monkeypatch.setattr(sys, "stdout", streams[0])
    monkeypatch.setattr(sys, "stderr", streams[1])
    monkeypatch.setattr(sys, "argv", ["tuner", *map(str, words)])
    try:
        code = guarded(_invoke)
    except SystemExit as ended:
        code = ended.code
    for stream in streams:
        stream.flush()
    return code, *(stream.buffer.getvalue() for stream in streams)


LETTERS = "Größe 漢字 🚁 ≤ − ²"
ENCODINGS = ("cp1252", "ascii", "latin-1", "cp437", "utf-16", "utf-8")


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_any_letter_passes_any_pipe_and_json_stays_the_same_json(encoding, tmp_path, monkeypatch):
    """A title in Chinese through a pipe in cp1252 ended in a traceback and exit code 1, which is a verdict."""
    text = QUICKSTART.read_text(encoding="utf-8").replace('title = "', f'title = "{LETTERS}', 1)
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    command = ("check", tmp_path / "study.toml", "--set", "margin=[]")
    code, out, _ = printed(monkeypatch, encoding, *command, "--json")
    assert code == 0 and json.loads(out.decode(encoding))["title"].startswith(LETTERS)
    code, out, _ = printed(monkeypatch, encoding, *command)
    assert code == 0 and "Gr" in out.decode(encoding)


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_an_error_about_any_letter_is_one_line(encoding, tmp_path, monkeypatch):
    name = tmp_path / f"漢字−{os.fsdecode(bytes([0xE4]))}.toml"
    code, _, err = printed(monkeypatch, encoding, "check", name)
    assert code == 2 and err.decode(encoding).count("\n") == 1 and "Traceback" not in err.decode(encoding)


WORDS = [
    *[(name, "--help") for name in get_group(app).commands],
    ("--help",),
    *[("list", kind) for kind in listings()],
    ("show", "RESULTS"),
    ("design", "quickstart"),
    ("report", "nowhere"),
]


@pytest.mark.parametrize("encoding", [pytest.param("cp1252", marks=pytest.mark.slow), "ascii"])
@pytest.mark.parametrize("words", WORDS, ids=" ".join)
def test_every_text_passes_a_pipe_of_few_letters(words, encoding, small_run, tmp_path, monkeypatch):
    # `design` writes gains.json into the folder that it is called in.
    monkeypatch.chdir(tmp_path)
    given = [small_run[1] if word == "RESULTS" else word for word in words]
    code, out, err = printed(monkeypatch, encoding, *given)
    assert code in (0, 1, 2) and (out or err) and b"Traceback" not in out + err


@pytest.mark.parametrize("debug", [False, True])
def test_a_defect_of_the_tool_has_an_exit_code_that_no_verdict_has(debug, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["tuner", *["--debug"] * debug])

    def broken():
        raise UnicodeEncodeError("cp1252", "−", 0, 1, "no such letter")

    assert guarded(broken) == CRASHED == 70
    err = capsys.readouterr().err
    assert "Traceback" in err and err.splitlines()[-1].startswith("Error: a defect of the tool")


@pytest.mark.parametrize(
    ("error", "code"), [(InputError("wrong"), 2), (OSError(28, "full"), 2), (MemoryError(), 70), (EOFError(), 70)]
)
def test_debug_changes_no_exit_code(error, code, monkeypatch, capsys):
    def failing():
        raise error

    for words in (["tuner"], ["tuner", "--debug"]):
        monkeypatch.setattr(sys, "argv", words)
        assert guarded(failing) == code
    assert "Traceback" in capsys.readouterr().err


def test_an_end_of_file_inside_of_a_command_is_no_verdict(monkeypatch, capsys):
    """The library of the command line makes "Aborted!" and exit code 1 of it."""

    def ended_early(*_):
        raise EOFError("no more")

    monkeypatch.setattr("tuner.cli.printers.listing.print_listing", ended_early)
    monkeypatch.setattr(sys, "argv", ["tuner", "list", "laws"])
    assert guarded(_invoke) == CRASHED
    assert "EOFError: no more" in capsys.readouterr().err


def test_an_installation_that_is_broken_ends_with_no_verdict(tmp_path):
    broken = "import sys; sys.modules['tuner.cli.main'] = None; from tuner.__main__ import run; run()"
    done = subprocess.run([sys.executable, "-c", broken], capture_output=True, check=False, timeout=120)
    assert done.returncode == CRASHED and b"Traceback" in done.stderr


@pytest.mark.parametrize(
    "words",
    [
        ("list", "laws"),
        *(
            pytest.param(words, marks=pytest.mark.slow)
            for words in (
                ("list", "laws", "--json"),
                ("run", "--help"),
                ("check", "quickstart", "--set", "margin=[]"),
            )
        ),
    ],
)
def test_a_reader_that_is_gone_is_no_verdict(words):
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run([sys.executable, "-c", CODE, *words], stdout=writer, stderr=subprocess.PIPE, check=False)
    os.close(writer)
    assert (done.returncode, done.stderr) == (CLOSED_PIPE, b"") and CLOSED_PIPE == 141


def test_exit_codes_are_documented():
    codes = re.findall(
        r"^\| (\d+) \|", (ROOT / "docs" / "reading_the_report.md").read_text(encoding="utf-8"), re.MULTILINE
    )
    assert codes == ["0", "1", "2", "3", "70", "130", "141"]
    assert "70" in (app.info.epilog or "")
