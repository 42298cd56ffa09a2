"""README and the pages of docs/ hold: links, commands, and every block of a shell or of Python, typed in an empty folder."""

import re
import shutil
from functools import cache

import pytest
from typer.testing import CliRunner

import tuner
from plant.quadrotor.airframes import load
from tests.pages import ROOT, TYPED, Block, Typist, blocks, commands, run_small
from tests.plant.own_files import forget
from tests.tuner.conftest import NoDrawing
from tests.tuner.report.fabricate import fabricate
from tuner import report
from tuner.cli.main import app

DOCS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
PAGES = {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in DOCS}
BLOCKS = {
    name: [block for block in blocks(text) if block.name or block.language in TYPED] for name, text in PAGES.items()
}
INLINE = [command for text in PAGES.values() for command in re.findall(r"`(tuner [^`]*)`", text)]
NOT_RUN = {
    r"^python3 bootstrap\.py|^bash \.ci/run|lock\.sh": "work on a checkout; CI types them",
    r"^(python3? -m|python3 -m) (pytest|benchmarks|tests)|^python docs/generator": "tests and benchmarks of a checkout",
    r"^pip install": "takes packages from a registry",
    r"^git |^make |^tuner confirm": "fetches and builds a firmware",
    r"^tuner autotune": "takes minutes; tests/tuner/extensions/autotune/test_autotuning.py carries it out on a small search",
    r"^tuner studio": "serves a page until Ctrl-C; tests/tuner/extensions/studio drives it",
    r"_jobqueue|dask_kubernetes": "needs a cluster",
    r"--measure": "needs a compiler for Arm and QEMU",
    r"python docs/ask_and_tell": "needs Gymnasium or RotorPy from a registry",
    r"^    (@property|FinalistColumn)": "lines for a file of the tool",
}
"""Commands of the pages that are not typed, with the reason; all others are."""
ELSEWHERE = {"docs/cluster.md"}
"""Pages whose commands tests/tuner/extensions/cluster/test_cluster_document.py types, with this machine for the others."""
OMITTED = re.compile("|".join(NOT_RUN), re.MULTILINE)
GIVEN = {
    "log15": "tests/tuner/extensions/logs/crazyflie/log15_70_to_85",
    "studies": "studies",
    "docs": "docs/ask_and_tell",
}
"""Files of a reader before a page begins, by a word of the page: a log, files of a clone, parameter files of vehicles."""
SHOWN_BEFORE = (
    "docs/from_file_and_back.md",
    "docs/own_plant.md",
    "docs/how_to/betaflight_adrc.md",
    "docs/how_to/judge.md",
    "docs/how_to/search_betaflight_adrc.md",
)
"""Pages whose files other pages use, by the names of the files."""
SLOW = {
    "README.md",
    "docs/ask_and_tell.md",
    "docs/cookbook.md",
    "docs/examples/dc_motor.md",
    "docs/examples/dead_time.md",
    "docs/examples/fixed_wing.md",
    "docs/examples/iron.md",
    "docs/examples/own_law.md",
    "docs/examples/two_masses.md",
    "docs/exports.md",
    "docs/from_file_and_back.md",
    "docs/how_to/add_a_law.md",
    "docs/how_to/add_a_metric.md",
    "docs/how_to/add_a_number.md",
    "docs/how_to/adrc_plants.md",
    "docs/how_to/betaflight_adrc.md",
    "docs/how_to/choices_beside_numbers.md",
    "docs/how_to/coming_from.md",
    "docs/how_to/compare.md",
    "docs/how_to/confirm.md",
    "docs/how_to/conflicting_limits.md",
    "docs/how_to/flight_limits.md",
    "docs/how_to/infeasible.md",
    "docs/how_to/judge.md",
    "docs/how_to/limits.md",
    "docs/how_to/model_accuracy.md",
    "docs/how_to/observer.md",
    "docs/how_to/period_and_delay.md",
    "docs/how_to/plan_a_flight.md",
    "docs/how_to/plant_margins.md",
    "docs/how_to/search_betaflight_adrc.md",
    "docs/how_to/share_own_code.md",
    "docs/how_to/start_from_a_run.md",
    "docs/how_to/study_size.md",
    "docs/how_to/textbook_pid.md",
    "docs/how_to/unstable_loop.md",
    "docs/how_to/which_law.md",
    "docs/identify.md",
    "docs/log_to_gains.md",
    "docs/own_plant.md",
    "docs/tails.md",
    "docs/tutorial.md",
}
"""Pages whose blocks take more than a second; .ci/run types them after the quick tests."""


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


def all_commands():
    """Every command of the tool that a page names, typed or not."""
    typed = [
        line for page in BLOCKS.values() for block in page if block.language != "python" for line in commands(block)
    ]
    stripped = [line.removeprefix("python3 bootstrap.py ") for line in [*typed, *INLINE]]
    return sorted({line for line in stripped if re.match("tuner [a-z]", line)})


@pytest.mark.parametrize("command", all_commands())
def test_every_command_and_option_exists(command):
    words = command.split()[1:]
    code, told = help_of(words[0])
    assert code == 0, command
    # Options of the program itself may stand behind a command.
    known = told + help_of()[1]
    for option in (word for word in words if word.startswith("--")):
        assert re.search(rf"{option}\b", known), option


def test_every_test_that_is_named_is_there():
    named = set(re.findall(r"\btests/[\w/-]+(?:\.\w+)?", "\n".join(PAGES.values())))
    assert len(named) > 8
    assert [name for name in named if not (ROOT / name).exists()] == []


def typed_pages():
    """The pages with something to type, as parameters; the long ones marked slow."""
    for name, page in BLOCKS.items():
        texts = [text for block in page if not block.name and block.language in TYPED for text in commands(block)]
        if name not in ELSEWHERE and any(not OMITTED.search(text) for text in texts):
            yield pytest.param(name, id=name, marks=pytest.mark.slow if name in SLOW else ())


@pytest.mark.parametrize("name", list(typed_pages()))
def test_blocks_of_a_page_run_as_typed(name, tmp_path, monkeypatch):
    """In an empty folder, top to bottom, with small searches; `NOT_RUN` says what is left out, `GIVEN` what is there."""
    # Figures and page take most of the time of a short run, and other tests look at them.
    monkeypatch.setattr(report, "start_figures", lambda folder: NoDrawing())
    monkeypatch.setattr(tuner, "run", run_small)
    for file, source in GIVEN.items():
        if re.search(rf"\b{file}\b", PAGES[name]):
            place(ROOT / source, tmp_path / (file if (ROOT / source).is_file() else source))
    typist = Typist(tmp_path)
    for block in (block for page in SHOWN_BEFORE for block in BLOCKS[page]):
        if block.name and block.name in PAGES[name]:
            typist.type(block, OMITTED)
    try:
        for block in BLOCKS[name]:
            typist.type(block, OMITTED)
    finally:
        forget()


def test_blocks_are_found_one_behind_the_other_and_files_by_their_names():
    page = "`a.toml`:\n\n```toml\nx = 1\n```\n\n```sh\ntuner run a.toml \\\n  --out b    # why\n```\n\n```python\nprint(1)\n```\n"
    file, shell, python = blocks(page)
    assert (file.name, file.text, shell.name, python.language) == ("a.toml", "x = 1\n", "", "python")
    assert [line.split() for line in commands(shell)] == [["tuner", "run", "a.toml", "--out", "b"]]


@pytest.mark.parametrize(
    "text", ["tuner check nowhere.toml", "cat nowhere", "tuner list laws > a && false"], ids=["tuner", "shell", "and"]
)
def test_a_command_that_fails_is_seen(text, tmp_path):
    with pytest.raises(AssertionError, match=re.escape(text)):
        Typist(tmp_path).type(Block("sh", text), OMITTED)


def place(source, target):
    """Copy a file or a folder."""
    if source.is_file():
        shutil.copy(source, target)
    else:
        shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__", "*.fmu"))


def test_what_is_not_typed_is_still_in_the_pages():
    texts = [text for page in BLOCKS.values() for block in page for text in commands(block)]
    assert [pattern for pattern in NOT_RUN if not any(re.search(pattern, text, re.MULTILINE) for text in texts)] == []


def file_of(page, name):
    """The content that a page gives a file."""
    return next(block.text for block in BLOCKS[page] if block.name == name)


def test_the_airframe_of_the_tutorial_is_one(tmp_path):
    file = tmp_path / "kestrel.toml"
    file.write_text(file_of("docs/tutorial.md", "kestrel.toml"), encoding="utf-8")
    airframe = load(file)
    assert airframe.vehicle.mass == 0.85
    assert all(number.source for number in airframe.sources.values())


@pytest.mark.parametrize(("page", "name"), [("add_a_law", "pid_plain.py"), ("add_a_metric", "mae.py")])
def test_user_code_of_a_page_is_that_of_the_shipped_study(page, name):
    """It is run by tests/tuner/experiments/again/test_own_code_run.py."""
    assert file_of(f"docs/how_to/{page}.md", name) == (ROOT / "studies/own_law" / name).read_text(encoding="utf-8")


def test_the_report_has_the_sections_that_are_explained(tmp_path):
    page = report.write_report(fabricate(tmp_path / "made-up")).read_text(encoding="utf-8")
    headings = re.findall(r"<h2[^>]*>([^<]*)</h2>", page)
    explained = re.findall(r"^## (.*)$", PAGES["docs/reading_the_report.md"], re.MULTILINE)
    # The first is about the lines at the top of a page without a feasible point, the last about another page.
    assert explained == ["Nothing feasible", "The table and the trade-off", *headings, "A contest or a comparison"]
