"""What reaches the terminal: no text of a file, no name and no argument steers it, colours anything or is taken for markup."""

import ast
import io
import json
import re
from pathlib import Path

import pytest
from rich.table import Table

import tuner.cli
from plant.texts import inert
from tests.tuner.exchange.hostile_texts import HOSTILE
from tests.tuner.extensions.contests.report.fabricate_contest import Made
from tests.tuner.extensions.contests.report.fabricate_contest import fabricate as fabricate_contest
from tests.tuner.in_process import tuner as command
from tests.tuner.report.fabricate import fabricate
from tuner.cli.terminal import Console
from tuner.text.inert_stream import InertStream

# What rich itself writes: colours and styles.
STYLE = re.compile(r"\x1b\[[0-9;]*m")
NASTY = "[red]a[/red] [/] :bomb: \x1b[31mb\x1b]0;c\x07 \u202ed \x9b31m \x7f"


def is_inert(text):
    return all(letter.isprintable() or letter in "\n\t" for letter in text)


def test_every_text_is_inert_and_tells_what_it_was():
    assert all(is_inert(inert(text)) for text in HOSTILE)
    assert inert("a\n\tb é 漢 🚁") == "a\n\tb é 漢 🚁"
    assert inert("\x1b\u202e\x7f\x9b\r\U000e0001") == "\\u001b\\u202e\\u007f\\u009b\\r\\udb40\\udc01"


@pytest.mark.parametrize("indent", [None, 2])
@pytest.mark.parametrize("ascii_only", [True, False])
def test_json_stays_json(indent, ascii_only):
    document = {text: [text, {"a": text}] for text in [*HOSTILE, "\U000e0001"]}
    text = inert(json.dumps(document, indent=indent, ensure_ascii=ascii_only))
    assert is_inert(text) and json.loads(text) == document


@pytest.mark.parametrize("text", [NASTY, *HOSTILE[:: len(HOSTILE) // 40]], ids=range(41))
def test_a_console_shows_texts_as_texts(text):
    out = io.StringIO()
    console = Console(file=out, force_terminal=True, width=20_000)
    table = Table(title=text)
    table.add_column(text)
    table.add_row(text)
    console.print(text)
    console.print(text, style="bold", highlight=False)
    console.print(table)
    said = STYLE.sub("", out.getvalue())
    assert is_inert(said)
    assert "".join(inert(text).split()) in "".join(said.split())


def test_a_stream_writes_what_is_inert_and_is_otherwise_the_one_behind():
    behind = io.StringIO()
    stream = InertStream(behind)
    print(NASTY, "é", file=stream)
    stream.writelines(["\x1b", "a\n"])
    assert behind.getvalue() == f"{inert(NASTY)} é\n\\u001ba\n" and is_inert(behind.getvalue())
    assert not stream.isatty() and stream.rich_proxied_file is behind


def made_up(folder, replaced):
    """A results folder in whose documents every title is hostile, as if an older version had written it."""
    fabricate(folder, 2, ("gusts",))
    count = 0
    for file in folder.glob("*.json"):
        text = file.read_text()
        for old in replaced(json.loads(text)):
            text = text.replace(json.dumps(old), json.dumps(NASTY))
            count += 1
        file.write_text(text)
    assert count
    return folder


def titles(document):
    return [document[key] for key in ("title", "tuned_why") if isinstance(document.get(key), str)]


@pytest.mark.parametrize("words", [["show"], ["show", "--json"], ["report"], ["compare"]])
def test_a_hostile_title_of_a_results_folder_is_inert(words, tmp_path, monkeypatch, capsys):
    folder = made_up(tmp_path / "results", titles)
    name, *options = words
    given = [folder, folder] if name == "compare" else [folder]
    code, out, err = command(monkeypatch, capsys, name, *given, *options)
    assert is_inert(out) and is_inert(err) and "Traceback" not in err
    if name == "show":
        assert code == 0
        assert json.loads(out)["title"] == NASTY if options else "[red]a[/red] [/] :bomb:" in out


@pytest.mark.parametrize("options", [[], ["--json"]])
def test_a_hostile_title_of_a_contest_is_inert(options, tmp_path, monkeypatch, capsys):
    folder = fabricate_contest(tmp_path / "contest", Made())
    file = folder / "contest.json"
    document = json.loads(file.read_text())
    title = document["title"]
    file.write_text(file.read_text().replace(json.dumps(title), json.dumps(NASTY)))
    code, out, err = command(monkeypatch, capsys, "show", folder, *options)
    assert code == 0 and is_inert(out + err) and (bool(options) or "[red]a[/red] [/] :bomb:" in out)


@pytest.mark.parametrize(
    "words",
    [
        ("check", "NAME"),
        ("run", "NAME"),
        ("show", "NAME"),
        ("validate", "NAME"),
        ("resume", "NAME"),
        ("report", "NAME"),
        ("export", "NAME", "--to", "NAME"),
        ("list", "NAME"),
        ("NAME",),
        ("fly", "--law", "NAME"),
        ("run", "--NAME"),
        ("run", "NAME", "--set", "NAME"),
        ("run", "NAME", "--dask", "NAME"),
        ("fly", "--seeds", "NAME"),
        ("schema", "NAME"),
    ],
    ids="-".join,
)
def test_a_hostile_argument_is_inert(words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    hostile = "a\x1b[31m\u202e\x07[red]b"
    code, out, err = command(monkeypatch, capsys, *[word.replace("NAME", hostile) for word in words])
    assert code == 2 and is_inert(out) and is_inert(err) and "Traceback" not in err
    assert not list(tmp_path.iterdir())


def test_a_study_of_a_hostile_file_name_is_inert(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for words in (["new"], ["check"], ["check", "--json"]):
        name = "a\x1b[31m\u202eb.toml"
        code, out, err = command(monkeypatch, capsys, words[0], name, *words[1:])
        assert is_inert(out + err) and "Traceback" not in err


def test_every_console_of_a_command_is_that_one():
    for file in Path(next(iter(tuner.cli.__path__))).rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.ImportFrom) and file.name != "terminal.py":
                assert (node.module or "") not in ("rich.console", "rich.markup"), file
