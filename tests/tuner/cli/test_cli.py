"""The command line as a user meets it: exit codes, one message and no traceback."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from typer.main import get_group
from typer.testing import CliRunner

from plant.errors import StoreError
from tests.tuner.conftest import QUICKSTART, SMALL
from tuner.api.catalogue import listings
from tuner.cli.app import EVERYDAY, command_groups
from tuner.cli.main import app, commands, named_command
from tuner.text.errors import NOTHING_FEASIBLE

ROOT = Path(__file__).parents[3]
COMMANDS = get_group(app).commands


def refused(done):
    assert done.returncode == 2, done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == ""
    return done.stderr


def help_of(command):
    return command.get_help(typer.Context(command))


@pytest.mark.parametrize("command", COMMANDS)
def test_help_has_an_example(command):
    done = CliRunner().invoke(app, [command, "--help"])
    assert done.exit_code == 0
    assert f"Example: tuner {command}" in " ".join(done.stdout.split())


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_is_built_without_the_others(command):
    alone, whole = commands(command).commands, get_group(app).commands
    assert list(alone) == [command]
    assert help_of(alone[command]) == help_of(whole[command])


@pytest.mark.parametrize("name", ["", "nonsense"])
def test_all_commands_are_built_where_none_is_named(name):
    assert list(commands(name).commands) == list(COMMANDS)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ([], ""),
        (["--help"], ""),
        (["run", "list"], "run"),
        (["--code", "run", "fly", "x"], "fly"),
        (["--code=run", "fly"], "fly"),
        (["--code", "run"], ""),
        (["--code"], ""),
    ],
)
def test_the_command_of_a_line_is_its_first_word_that_no_option_takes(arguments, name):
    assert named_command(arguments) == name


def test_help_has_every_command_below_one_heading():
    groups = command_groups(COMMANDS)
    listed = [name for names in groups.values() for name in names]
    assert sorted(listed) == sorted(COMMANDS) and groups["Every day"] == list(EVERYDAY)
    text = CliRunner().invoke(app, ["--help"]).stdout
    assert "..." not in text.partition("Options:")[2]
    assert all(f"\n{heading}:\n" in text for heading in groups)


NO_NUMBERS = ("numpy", "numba", "casadi", "pandas", "plotly", "matplotlib", "pymoo", "pydantic")
NO_COMPILER = ("numba", "casadi", "scipy", "pandas")


def test_help_does_not_import_the_heavy_libraries_and_a_listing_no_compiler():
    """Numba takes 0.4 s of processor time to import, and lists compile nothing; one process for all, which takes as long."""
    listings = [(("list", *what), NO_COMPILER) for what in ((), ("targets",), ("firmwares",))]
    calls = [(("--help",), NO_NUMBERS), *listings]
    code = (
        "import sys\nfrom typer.testing import CliRunner\nfrom tuner.cli.main import app\n"
        f"for words, heavy in {calls}:\n"
        "    assert CliRunner().invoke(app, list(words)).exit_code == 0, words\n"
        "    print(words, [name for name in heavy if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [f"{words} []" for words, _ in calls]


PLAIN_RUN = """
import sys
from tuner.cli import main
sys.argv = ["tuner", "run", *sys.argv[1:]]
def told(code):
    print("imported:", [name for name in {heavy} if name in sys.modules], file=sys.stderr)
    sys.exit(code)
main.leave = told
main.main()
"""
# What takes 20 ms of processor time or more to import, and a tuning run from its study to the printed answer does without. (Its figures
# are drawn by another process, with imports of its own.)
NOT_FOR_A_RUN = (
    "pandas",
    "pyarrow",
    "scipy.stats",
    "scipy.signal",
    "scipy.optimize",
    "scipy.interpolate",
    "scipy.sparse.csgraph",
    "scipy.integrate",
    "matplotlib",
    "pymoo",
    "cvxpy",
    "control",
    "numba.cpython.heapq",
    "jsonschema",
    "scipy.sparse",
    "scipy.spatial",
    "plotly",
    "fontTools",
    "PIL",
    "tuner.report.charts.paper",
    "tuner.extensions.contests.run",
    "tuner.extensions.trials.run",
    "tuner.exchange.registry",
)


@pytest.mark.slow
def test_a_run_imports_nothing_heavy_that_it_does_without(tmp_path):
    # The search of its own choice: NSGA-II is of pymoo.
    small = [f"--set={key}={value}" for key, value in SMALL.items() if key not in ("margin", "search.algorithm")]
    command = [sys.executable, "-c", PLAIN_RUN.replace("{heavy}", repr(NOT_FOR_A_RUN)), str(QUICKSTART), *small]
    done = subprocess.run([*command, "--out", str(tmp_path / "out")], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode in (0, NOTHING_FEASIBLE), done.stderr
    assert (tmp_path / "out" / "report.html").exists()
    assert done.stderr.splitlines()[-1] == "imported: []"


@pytest.mark.slow
def test_margins_import_nothing_of_scipy_nor_what_writes_results(small_run):
    heavy = (
        *NOT_FOR_A_RUN[:2],
        "scipy.linalg",
        "scipy.special",
        "numpy.f2py",
        "plotly",
        "moocore",
        "rich.progress",
    )
    code = PLAIN_RUN.replace("{heavy}", repr(heavy)).replace('"run"', '"margins"')
    command = [sys.executable, "-c", code, str(small_run[1])]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.stderr.splitlines()[-1] == "imported: []", done.stderr


@pytest.mark.parametrize("what", listings())
def test_list_as_table_and_json(what, tuner):
    rows = json.loads(tuner("list", what, "--json").stdout)
    assert rows
    first = str(next(iter(rows[0].values())))
    assert first in tuner("list", what).stdout.replace("\n", "")


def test_the_help_of_list_names_every_listing():
    said = " ".join(CliRunner().invoke(app, ["list", "--help"]).stdout.replace(",", "").replace(".", "").split())
    assert [what for what in listings() if f" {what} " not in said] == []


def test_list_of_nothing_known_names_the_nearest(tuner):
    assert "did you mean 'laws'" in refused(tuner("list", "lawz"))


def test_check_says_what_a_study_would_fly(tuner):
    figures = json.loads(tuner("check", QUICKSTART, "--set", "margin=[]", "--json").stdout)
    assert figures["search_flights"] == 12 * 12 * 8


def test_new_writes_a_study_that_loads_and_never_overwrites(tmp_path, tuner, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert tuner("new", "my_quad").returncode == 0
    assert tuner("check", "my_quad.toml").returncode == 0
    before = (tmp_path / "my_quad.toml").read_bytes()
    assert "exists already" in refused(tuner("new", "my_quad"))
    assert (tmp_path / "my_quad.toml").read_bytes() == before


def test_run_fly_report_one_after_the_other(tmp_path, tuner):
    folder = tmp_path / "out"
    small = [
        "--set",
        "search.population=8",
        "--set",
        "search.generations=2",
        "--set",
        "scenario.0.search=4",
        "--set",
        "scenario.0.held_out=16",
        "--set",
        "margin=[]",
    ]
    done = tuner("run", QUICKSTART, "--out", folder, "--threads", 2, *small)
    assert done.returncode == 0, done.stderr
    assert "generation 2/2" in done.stdout
    # Two generations from nothing find nothing better: 16 candidates have 4 flights each.
    assert (
        "Keep the default gains: " in done.stdout and f"Results in {folder}: report.html, gains.json (" in done.stdout
    )
    assert "exists already" in refused(tuner("run", QUICKSTART, "--out", folder, *small))
    picture = tmp_path / "fly.png"
    flown = tuner("fly", folder / "gains.json", "--seeds", 16, "--plot", picture, "--json")
    assert flown.returncode == 0, flown.stderr
    figures = json.loads(flown.stdout)
    assert figures["flights"] == 16
    assert {"itae.position", "travel", "failure"} <= {row["metric"] for row in figures["metrics"]}
    assert picture.read_bytes().startswith(b"\x89PNG")
    (folder / "report.html").unlink()
    assert tuner("report", folder).returncode == 0
    assert (folder / "report.html").stat().st_size > 1_000_000


@pytest.mark.parametrize("as_json", [[], ["--json"]])
def test_the_answer_of_a_run_is_printed_before_its_report_is_written(tmp_path, tuner, monkeypatch, as_json):
    def broken(*_):
        raise StoreError("no page today")

    monkeypatch.setattr("tuner.report.write_report", broken)
    small = {
        "search.population": 8,
        "search.generations": 1,
        "scenario.0.search": 4,
        "scenario.0.held_out": 16,
        "margin": "[]",
    }
    changes = [word for key, value in small.items() for word in ("--set", f"{key}={value}")]
    done = tuner("run", QUICKSTART, "--out", tmp_path / "out", *changes, *as_json)
    assert done.returncode == 2 and "no page today" in done.stderr
    if as_json:
        assert json.loads(done.stdout)["title"].startswith("Quickstart")
    else:
        assert f"Results in {tmp_path / 'out'}: report.html, gains.json (" in done.stdout.replace("\n", "")


def test_bad_input_is_one_line_on_stderr(tmp_path, tuner):
    broken = tmp_path / "broken.toml"
    broken.write_text(QUICKSTART.read_text().replace("population = 12", "populaton = 12"))
    message = refused(tuner("run", broken, "--out", tmp_path / "never"))
    assert message.count("\n") == 1
    assert "search.populaton" in message and "did you mean 'population'" in message and str(broken) in message
    assert not (tmp_path / "never").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "nowhere.toml"], "there is no such file"),
        (["run", QUICKSTART, "--set", "search.generations"], "KEY=VALUE"),
        (["fly"], "--law"),
        (["fly", "nowhere.json"], "there is no such file"),
        (["fly", "--law", "hybird"], "did you mean 'hybrid'"),
        (["fly", "--law", "hybrid", "--airframe", "iriss"], "did you mean 'iris'"),
        (["fly", "--law", "hybrid", "--study", QUICKSTART, "--scenario", "3"], "allowed: 0 to 0"),
        (["report", "nowhere"], "there is no such results folder"),
        (["run", QUICKSTART, "--treads", "2"], "--treads"),
    ],
)
def test_bad_arguments(arguments, words, tuner):
    assert words in refused(tuner(*arguments))


def test_debug_shows_the_traceback():
    command = [sys.executable, "-c", "from tuner.cli.main import main; main()", "--debug", "fly", "nowhere.json"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 2
    assert "Traceback" in done.stderr


def test_list_alone_says_what_there_is_to_list():
    done = CliRunner().invoke(app, ["list"])
    assert done.exit_code == 0 and all(name in done.stdout for name in listings())
    rows = json.loads(CliRunner().invoke(app, ["list", "--json"]).stdout)
    assert {row["what"] for row in rows} == set(listings()) and all(row["rows"] > 0 and row["about"] for row in rows)
    assert "Control laws and their gains\n" in "\n".join(map(str.rstrip, done.stdout.splitlines()))
