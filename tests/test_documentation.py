"""The site of the documentation: its generated pages are complete, and every page has its place."""

import re
import subprocess
import sys
from dataclasses import fields
from importlib import import_module
from pathlib import Path
from xml.etree import ElementTree

import pytest

from plant.law_registry import LAWS
from plant.laws.law_text import USE, law_text
from plant.model.signals import SIGNALS
from tuner.cli.main import app
from tuner.extensions.agents.tools import commands
from tuner.study.schema import StrictTable

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def generator():
    """The modules that make the pages."""
    sys.path.insert(0, str(ROOT / "docs" / "generator"))
    yield import_module("pages"), import_module("reference"), import_module("law_pages").plain
    sys.path.remove(str(ROOT / "docs" / "generator"))


@pytest.fixture(scope="module")
def site(generator):
    """All pages of the site, Markdown by path."""
    return generator[0].pages()


TABLES = re.compile(r"\w+Table\b")


def tables(model):
    """The tables of a study file below a model, that one first."""
    yield model
    inner = {name for entry in model.model_fields.values() for name in TABLES.findall(str(entry.annotation))}
    for table in StrictTable.__subclasses__():
        if table.__name__ in inner:
            yield from tables(table)


def test_every_key_of_a_study_file_has_a_meaning_and_a_row(generator, site):
    page = site["study_file.md"]
    for _, model in generator[1].KINDS:
        for table in tables(model):
            for key, entry in table.model_fields.items():
                name = entry.alias or key
                nested = TABLES.search(str(entry.annotation))
                row = re.search(rf"^\| `{name}` \| (.*) \|$", page, re.MULTILINE)
                assert nested or (row and row.group(1).rstrip()[-1:] not in ("", "|")), f"{table.__name__}.{name}"
    for head in (
        "[airframe]",
        "[gains]",
        "[[scenario]]",
        "[scenario.air.gust]",
        "[[margin]]",
        "[[contender]]",
        "[plant]",
        "[[actuator]]",
        "[[channel]]",
        "[scenario.sensors.NAME]",
        "[scenario.reference.NAME], [scenario.disturbance.NAME]",
    ):
        assert f"### {head}\n" in page


def test_every_signal_of_a_plant_is_told_with_its_keys(site):
    for kind, signal in SIGNALS.items():
        row = re.search(rf"^\| `{kind}` \| (.*) \|$", site["study_file.md"], re.MULTILINE)
        assert row and all(f"{entry.name} = " in row.group(1) for entry in fields(signal)), kind


def test_every_key_of_gains_json_has_a_row(site):
    page = site["gains_keys.md"]
    rows = set(re.findall(r"^\| `(\w+)` \|", page, re.MULTILINE))
    assert {
        "format",
        "airframe",
        "controller",
        "gains",
        "margins",
        "objectives",
        "exports",
        "sha256",
        "phase_margin",
    } <= rows
    assert "quantity in `kg`" in page


def test_every_command_and_registry_is_told(site):
    told = re.findall(r"^## tuner ([\w-]+)$", site["commands.md"], re.MULTILINE)
    assert len(told) == len(app.registered_commands)
    assert {"hybrid", "itae", "phase_margin", "nsga2", "px4", "quickstart"} <= set(
        re.findall(r"^\| ([\w-]+) \|", site["choices.md"], re.MULTILINE)
    )
    assert "/" + "work" not in site["choices.md"] and str(ROOT) not in "".join(site.values())


def test_every_law_has_its_section(generator, site):
    sections = dict(zip(LAWS, re.split(r"^## \w+$", site["laws.md"], flags=re.MULTILINE)[1:], strict=True))
    for law in LAWS.values():
        text, shown = law_text(law), sections[law.name]
        assert (
            f"```text\n{text.equations}\n```" in shown and text.use.startswith(USE) and generator[2](text.use) in shown
        )
        drawing = ElementTree.fromstring(shown[shown.index("<svg") : shown.index("</svg>") + len("</svg>")])
        labels = {entry.text for entry in drawing.iter("text")}
        assert {law.blocks.feedback, law.blocks.measured or "r", "u", "y"} <= labels
        for gain in law.gains:
            assert re.search(rf"^\| `{gain.name.rstrip('_')}` \| `{re.escape(gain.symbol)}` \|", shown, re.MULTILINE)


@pytest.mark.parametrize("law", [law for law in LAWS.values() if not law.on_airframe], ids=lambda law: law.name)
def test_equations_hold_every_gain_by_its_symbol(law):
    equations = law_text(law).equations
    missing = [gain.symbol for gain in law.gains if not re.search(rf"(?<![a-z]){gain.symbol}(?!\w)", equations)]
    assert missing == [] and ("z3' = " in equations) == ("z3" in law.blocks.feedback)


def test_every_page_has_its_place_in_the_navigation(generator, site):
    placed = [name for names in generator[0].NAVIGATION.values() for name in names]
    assert len(placed) == len(set(placed))
    assert {f"{name}.md" for name in placed} == {name for name in site if not name.startswith("source/")} - {"index.md"}


def test_links_of_pages_outside_the_folder_are_turned(site):
    assert "](tutorial.md)" in site["index.md"] and "](docs/" not in site["index.md"]
    assert "](source/plant/vectors.py.md)" in site["paper.md"]
    assert "class Rotors" in site["source/plant/vectors.py.md"]


def test_the_glossary_is_in_order():
    words = re.findall(r"^\*\*([^*]+)\*\*: ", (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert len(words) >= 50
    assert words == sorted(words, key=str.lower)


def test_every_study_of_ones_own_code_and_every_program_has_its_page(site):
    """By its name, with the command that runs it and a link to its files."""
    studies = {file.stem for file in (ROOT / "studies").glob("*.py")} | {"own_law"}
    programs = {"pendulum": "gymnasium", "rotorpy_hover": "rotorpy"}
    assert set(programs) == {file.stem for file in (ROOT / "docs/ask_and_tell").glob("*.py")}
    for page, files in {**{name: name for name in studies}, **{page: name for name, page in programs.items()}}.items():
        text = (ROOT / f"docs/examples/{page}.md").read_text(encoding="utf-8")
        assert f"{files}.toml)" in text and ("tuner run " in text or "tuner ask " in text)
        assert f"examples/{page}.md" in site


@pytest.fixture(scope="module")
def figures(generator):
    """The module that writes the tables of pages."""
    return import_module("figures")


def test_every_table_of_runs_has_its_place(figures):
    for table in figures.TABLES:
        text = (ROOT / table.page).read_text(encoding="utf-8")
        assert len(figures.marked(table.name).findall(text)) == 1, table.name
    names = re.findall(r"<!-- figures (\w+) -->", "\n".join(page.read_text() for page in pages_with_marks()))
    assert sorted(names) == sorted(table.name for table in figures.TABLES)


def pages_with_marks():
    """The pages of the repository that may hold tables of runs."""
    return [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]


def test_a_table_differs_by_a_word_or_by_a_number_beyond_the_tolerance(figures):
    row = "| travel [1/s] | 8.78 [8.76, 8.80] |"
    assert not figures.differs(row, row.replace("8.78", "8.90"))
    assert figures.differs(row, row.replace("8.78", "9.78"))
    assert figures.differs(row, row.replace("travel", "noise"))
    assert figures.differs(row, row + row)


@pytest.mark.slow
def test_tables_of_pages_are_those_of_their_runs():
    """The quick ones; `python docs/generator/figures.py --check` compares all."""
    command = [sys.executable, "docs/generator/figures.py", "--check", "quickstart", "costs", "my_motor", "dead_time"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_page_of_agents_has_the_table_of_the_server(generator):
    page = (ROOT / "docs" / "agents.md").read_text(encoding="utf-8")
    agent_tools = import_module("agent_tools")
    assert agent_tools.with_table(page) == page, "run `python docs/generator/agent_tools.py`"
    changed = page.replace("| `tail` |", "| `tales` |")
    assert changed != page and agent_tools.with_table(changed) == page
    assert all(f"| `{name}` |" in page for name in commands())


def test_what_the_theme_lacks_for_keyboards_and_screen_readers_is_mended(generator):
    accessible = import_module("accessible").accessible
    page = (
        '<p class="caption" role="heading">Begin</p><aside class="sidebar-drawer"></aside><aside class="toc-drawer no-toc">'
        '</aside><pre>x</pre><div class="table-wrapper docutils container"><th class="head text-right"><p></p></th></div>'
        '<div id="search-results"></div>'
    )
    assert accessible(page) == (
        '<p class="caption" role="heading" aria-level="2">Begin</p><aside class="sidebar-drawer" aria-label="Pages"></aside>'
        '<aside aria-label="On this page" class="toc-drawer no-toc"></aside><pre tabindex="0">x</pre>'
        '<div tabindex="0" class="table-wrapper docutils container"><th class="head text-right">'
        '<p class="visually-hidden">row</p></th></div><h1>Search</h1>\n<div id="search-results"></div>'
    )
