"""The pages of docs/ that show commands hold: links, commands, the airframe, the law and the metric that they show."""

import json
import re
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from typer.testing import CliRunner

from plant.airframes import load
from tests.tuner.conftest import NoDrawing
from tests.tuner.in_process import tuner
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
# Of the pages on laws and metrics; a contract finds its entries by itself.
CONTRACTS = [line.split() for line in COMMANDS if re.match(r"python3 -m pytest tests/\S+\.py -k ", line)]
# Few and short flights, none that asks for margins.
SMALL = [
    argument
    for change in (
        "search.population=8", "search.generations=2", "scenario.0.search=4", "scenario.0.held_out=16",
        "scenario.0.duration=2.0", "margin=[]", "mission.off=[\"rms.position\"]",
    )
    for argument in ("--set", change)
]  # fmt: skip


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


@pytest.mark.parametrize("command", TUNER)
def test_every_command_and_option_exists(command):
    words = command.split()[1:]
    result = CliRunner().invoke(app, [words[0], "--help"], terminal_width=200)
    assert result.exit_code == 0, command
    for option in (word for word in words if word.startswith("--")):
        assert re.search(rf"{option}\b", result.output), option


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
        cwd=folder, capture_output=True, text=True, check=False, env={"PYTHONPATH": str(ROOT), "PATH": ""},
    )  # fmt: skip
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
    monkeypatch.setattr(report, "write_report", lambda folder: None)
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


@pytest.fixture(scope="module")
def scratch(tmp_path_factory):
    """A copy of the packages and tests with the tutorial's law and metric in it."""
    folder = tmp_path_factory.mktemp("scratch")
    for name in ("plant", "objectives", "tuner", "tests"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", folder)
    (folder / "plant/laws/pid_plain.py").write_text(BLOCKS["plant/laws/pid_plain.py"], encoding="utf-8")
    put(folder / "plant/laws/__init__.py", "    pid,\n", "    pid_plain,\n")
    put(folder / "plant/laws/__init__.py", "    pid.LAW,\n", "    pid_plain.LAW,\n")
    entry = textwrap.indent(textwrap.dedent(BLOCKS["objectives/metrics/axis.py"]), "    ")
    put(folder / "objectives/metrics/axis.py", "AXIS_METRICS = (\n", entry)
    return folder


def put(file, after, text):
    """Put lines behind the one place where others stand."""
    before = file.read_text(encoding="utf-8")
    assert before.count(after) == 1
    file.write_text(before.replace(after, after + text), encoding="utf-8")


def run_there(scratch, *arguments, allowed=(0,)):
    done = subprocess.run(
        [sys.executable, *arguments], cwd=scratch, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode in allowed, done.stdout + done.stderr
    return done.stdout


CALLED = "import sys; sys.path.insert(0, '.'); from tuner.cli.main import main; main()"


def test_what_is_added_keeps_the_contract_of_its_kind(scratch):
    """With the commands of the page, both in one process; a contract finds its entries by itself, so there must be such tests."""
    files, names = [words[3] for words in CONTRACTS], [words[5] for words in CONTRACTS]
    assert names == ["pid_plain", "mae"]
    out = run_there(
        scratch, "-m", "pytest", "-n", "0", *files, "-k", " or ".join(names), "-q", "-rp", "-p", "no:cacheprovider"
    )
    for name in names:
        assert sum(line.startswith("PASSED") and name in line for line in out.splitlines()) >= 5


def test_what_is_added_is_listed_and_can_be_asked_for(scratch):
    """And its study is checked; no flight is compiled."""
    laws = json.loads(run_there(scratch, "-c", CALLED, "list", "laws", "--json"))
    assert {row["gain"] for row in laws if row["law"] == "pid_plain"} == {"kp", "ki", "kd"}
    assert any(
        row["metric"] == "mae" for row in json.loads(run_there(scratch, "-c", CALLED, "list", "metrics", "--json"))
    )
    study = (ROOT / "studies" / "quickstart.toml").read_text(encoding="utf-8")
    head, rest = study.split("[gains]\n")
    head = re.sub(r'attitude = "\w+"', 'attitude = "pid_plain"', head)
    rest = '"attitude.kp" = {}\n\n' + rest[rest.index("[[scenario]]") :]
    (scratch / "asked.toml").write_text(
        f"{head}[gains]\n{rest}".replace("itae.position", "mae.position"), encoding="utf-8"
    )
    figures = json.loads(run_there(scratch, "-c", CALLED, "check", "asked.toml", "--json"))
    assert figures["objectives"][0] == "cvar80(mae.position)"


def test_two_files_are_all_that_a_law_takes(scratch):
    """gains.json tells how the law is sampled and is valid, and its margins are worked out; the page says no more than that."""
    assert "These two files are all" in TEXT
    written = {path for path in BLOCKS if path.startswith(("plant/", "objectives/", "tuner/"))}
    assert written == {"plant/laws/pid_plain.py", "objectives/metrics/axis.py"}
    study = (ROOT / "studies" / "quickstart.toml").read_text(encoding="utf-8")
    head, rest = study.split("[gains]\n")
    head = re.sub(r'(attitude|position) = "\w+"', r'\1 = "pid_plain"', head)
    (scratch / "both.toml").write_text(
        f'{head}[gains]\n"attitude.kp" = {{}}\n\n{rest[rest.index("[[scenario]]") :]}', encoding="utf-8"
    )
    run_there(scratch, "-c", CALLED, "design", "both.toml", "--out", "plain.json")
    gains = json.loads((scratch / "plain.json").read_text(encoding="utf-8"))
    sampled = "integral: forward Euler, in force one period after it is formed; command held over the control period"
    assert gains["controller"]["discretisation"] == {"position": sampled, "attitude": sampled}
    run_there(scratch, "-c", CALLED, "validate", "plain.json")
    # The defaults of a law need not keep the limits of a study: exit code 1.
    margins = json.loads(run_there(scratch, "-c", CALLED, "margins", "plain.json", "--json", allowed=(0, 1)))
    assert margins["laws"] == {"position": "pid_plain", "attitude": "pid_plain"}
    assert all(channel["stable"] for channel in margins["channels"])


def test_the_report_has_the_sections_that_are_explained(tmp_path):
    page = report.write_report(fabricate(tmp_path / "made-up")).read_text(encoding="utf-8")
    headings = re.findall(r"<h2[^>]*>([^<]*)</h2>", page)
    explained = re.findall(r"^## (.*)$", READING, re.MULTILINE)
    # The first is about the lines at the top of a page without a feasible point, the last about another page.
    assert explained == ["Nothing feasible", "The table and the trade-off", *headings, "A contest or a comparison"]
