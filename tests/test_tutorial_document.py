"""The pages of docs/ that show commands hold: links, commands, the airframe, the law and the metric that they show."""

import contextlib
import json
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest
from typer.testing import CliRunner

from plant.quadrotor.airframes import load
from tests.plant.own_files import forget
from tests.tuner.conftest import NoDrawing
from tests.tuner.in_process import called, tuner
from tests.tuner.report.fabricate import fabricate
from tuner import report
from tuner.cli.main import app

ROOT = Path(__file__).parents[1]
READING = (ROOT / "docs" / "reading_the_report.md").read_text(encoding="utf-8")
DOCS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
TEXT = "\n".join(path.read_text(encoding="utf-8") for path in DOCS)
# A block that is the content of a file stands below a line that begins with the file's name.
BLOCKS = dict(re.findall(r"^`([\w./]+)`[^\n]*:\n\n```\w+\n(.*?)```", TEXT, re.MULTILINE | re.DOTALL))
FENCED = re.findall(r"```sh\n(.*?)```", TEXT, re.DOTALL)
INLINE = re.findall(r"`(tuner [^`]*)`", TEXT)
LINES = [
    line.removeprefix("python3 bootstrap.py ").partition("  #")[0] for block in FENCED for line in block.splitlines()
]
COMMANDS = [line.rstrip() for line in LINES] + INLINE
TUNER = sorted({command for command in COMMANDS if re.match("tuner [a-z]", command)})
# Few and short flights, none that asks for margins.
SMALL = [
    argument
    for change in (
        "search.population=8",
        "search.generations=2",
        "scenario.0.search=4",
        "scenario.0.held_out=16",
        "scenario.0.duration=2.0",
        "margin=[]",
        'mission.off=["rms.position"]',
    )
    for argument in ("--set", change)
]


def slug(heading):
    """A heading as GitHub names it: lower case, punctuation dropped, spaces turned into hyphens."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


@pytest.mark.parametrize("path", DOCS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_every_link_points_at_something(path):
    """Headings of other pages are looked at by the build of the site."""
    text = path.read_text(encoding="utf-8")
    targets = re.findall(r"\]\(([^)\s]+)\)", text)
    anchors = {slug(heading) for heading in re.findall(r"^#+ (.*)$", text, re.MULTILINE)}
    anchors |= set(re.findall(r'<a id="(\w+)">', text))
    assert [t for t in targets if t.startswith("#") and t[1:] not in anchors] == []
    files = [t.partition("#")[0] for t in targets if not t.startswith(("#", "http"))]
    assert [file for file in files if not (path.parent / file).exists()] == []


@cache
def help_of(*words):
    """The exit code and help of a command; pages name each a dozen times."""
    result = CliRunner().invoke(app, [*words, "--help"], terminal_width=200)
    return result.exit_code, result.output


@pytest.mark.parametrize("command", TUNER)
def test_every_command_and_option_exists(command):
    words = command.split()[1:]
    code, told = help_of(words[0])
    assert code == 0, command
    # Options of the program itself may stand behind a command.
    known = told + help_of()[1]
    for option in (word for word in words if word.startswith("--")):
        assert re.search(rf"{option}\b", known), option


def test_every_test_that_is_named_is_there():
    named = set(re.findall(r"\btests/[\w/-]+(?:\.\w+)?", TEXT))
    assert len(named) > 8
    assert [name for name in named if not (ROOT / name).exists()] == []


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """The folder of someone who follows the tutorial: an airframe and a study with it."""
    folder = tmp_path_factory.mktemp("tutorial")
    (folder / "kestrel.toml").write_text(BLOCKS["kestrel.toml"], encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", "from tuner.cli.main import main; main()", "new", "first"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        env={"PYTHONPATH": str(ROOT), "PATH": ""},
    )
    assert done.returncode == 0, done.stderr
    study = folder / "first.toml"
    text, count = re.subn(r"\[airframe\]\n.*?\n\n", BLOCKS["first.toml"] + "\n", study.read_text(), flags=re.DOTALL)
    assert count == 1
    study.write_text(text, encoding="utf-8")
    return folder


def test_the_airframe_is_one(home):
    airframe = load(home / "kestrel.toml")
    assert airframe.vehicle.mass == 0.85
    assert all(number.source for number in airframe.sources.values())


def test_the_commands_of_the_first_part_one_after_the_other(home, monkeypatch, capsys):
    """As written, but for a small search and few flights; `tuner margins` and `tuner design` have tests of their own."""
    monkeypatch.chdir(home)
    # Pictures and page take most of the time of a short run, and other tests look at them.
    monkeypatch.setattr(report, "write_report", lambda *_: None)
    monkeypatch.setattr(report, "start_figures", lambda folder: NoDrawing())

    def typed(command, *more, allowed=(0,)):
        assert command in COMMANDS, f"the page does not say {command}"
        code, out, err = tuner(monkeypatch, capsys, *command.split()[1:], *more)
        assert code in allowed, err
        return out

    assert "6" in next(line for line in typed("tuner check first.toml").splitlines() if line.startswith("variables"))
    typed("tuner run first.toml", *SMALL, "--threads", 2)
    assert "@ recommended" in typed("tuner show results/first")
    # The small search asked for no margins, so the gains may well break those of the study.
    asked = "tuner check results/first/gains.json --requirements first.toml"
    judged = json.loads(typed(asked, "--seeds", 4, "--json", allowed=(0, 1)))
    assert {"mean(failure)", "phase_margin", "ms"} <= {row["label"] for row in judged["rows"]}
    typed("tuner fly results/first/gains.json --seeds 256 --plot fly.png", "--seeds", 4)
    assert (home / "fly.png").read_bytes().startswith(b"\x89PNG")
    gains = json.loads((home / "results/first/gains.json").read_text())
    assert gains["airframe"]["name"] == "kestrel"
    (home / "designed.json").write_text(json.dumps(gains))
    assert "tuner compare results/first designed.json --seeds 256 --out comparison" in COMMANDS
    code, out, err = tuner(monkeypatch, capsys, "compare", "results/first", "designed.json", "--seeds", 4)
    assert code == 0 and "designed" in out, err


OWN = ("pid_plain.py", "mae.py", "sway.py")


@pytest.mark.parametrize("name", OWN)
def test_code_of_ones_own_is_that_of_the_shipped_study(name):
    """Which tests/tuner/experiments/again/test_own_code_run.py runs."""
    assert BLOCKS[name] == (ROOT / "studies/own_law" / name).read_text(encoding="utf-8")


def test_code_of_ones_own_keeps_its_contract_and_is_listed_where_it_is_named(tmp_path):
    for name in OWN:
        (tmp_path / name).write_text(BLOCKS[name], encoding="utf-8")
        assert "keeps its contract" in run_there(tmp_path, "check", name)
    laws = json.loads(run_there(tmp_path, "list", "laws", "--json", "--code", "pid_plain.py"))
    assert {row["gain"] for row in laws if row["law"] == "pid_plain"} == {"kp", "ki", "kd"}
    metrics = json.loads(run_there(tmp_path, "list", "metrics", "--json", "--code", "mae.py"))
    assert any(row["metric"] == "mae" for row in metrics)


def run_there(folder, *arguments):
    """Run a command in a folder, forget the code that it named, and return what it prints."""
    with contextlib.chdir(folder):
        code, out, err = called(*arguments)
    forget()
    assert code == 0, out + err
    return out


def test_the_report_has_the_sections_that_are_explained(tmp_path):
    page = report.write_report(fabricate(tmp_path / "made-up")).read_text(encoding="utf-8")
    headings = re.findall(r"<h2[^>]*>([^<]*)</h2>", page)
    explained = re.findall(r"^## (.*)$", READING, re.MULTILINE)
    # The first is about the lines at the top of a page without a feasible point, the last about another page.
    assert explained == ["Nothing feasible", "The table and the trade-off", *headings, "A contest or a comparison"]
