"""docs/paper.md points at what is there: files, functions, tests, laws, entries and default gains."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

from plant.law_registry import LAWS

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "paper.md"
TEXT = PAGE.read_text(encoding="utf-8")
LINKS = re.findall(r"\[([^\]]*)\]\(([^)\s]+)\)", TEXT)
RELATIVE = [(text, target) for text, target in LINKS if not target.startswith(("http", "#"))]
CODE = [(text.strip("`"), target) for text, target in RELATIVE if re.fullmatch(r"`\w+`", text)]
ENTRIES = [f"e{i}" for i in range(1, 21)] + [f"a{i}" for i in range(1, 23)]
# A backticked word of this form can only be a law.
LAW_NAME = r"`((?:pid|l?adrc|hybrid|supertwisting)(?:_[a-z0-9_]+)?)`"


@cache
def names_in(path: Path) -> frozenset[str]:
    """Names that a Python file defines at its top level, in its classes, or inside a function."""
    nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
    defined = {node.name for node in nodes if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    assigned = {node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
    return frozenset(defined | assigned)


def entry(anchor: str) -> str:
    """The text of one entry: up to the next heading for an erratum, the row of the table for an open point."""
    end = r"(?=\n#+ )" if anchor.startswith("e") else r"(?=\n)"
    found = re.search(rf'<a id="{anchor}"></a>(.*?){end}', TEXT, re.DOTALL)
    assert found, f"the page has no entry {anchor}"
    return found.group(1)


def test_every_relative_link_points_at_something() -> None:
    missing = [target for _, target in RELATIVE if not (PAGE.parent / target).exists()]
    assert missing == []
    assert len(RELATIVE) > 100


def test_every_equation_has_its_entry_and_in_order() -> None:
    """63 displayed equations: **(1)**, **(7), (8)** or **(53) to (57)**."""
    found: list[int] = []
    for heads in re.findall(r"^\*\*(\(\d+\).*?)\*\*", TEXT, re.MULTILINE):
        numbers = [int(number) for number in re.findall(r"\((\d+)\)", heads)]
        found += range(numbers[0], numbers[-1] + 1) if " to " in heads else numbers
    assert found == list(range(1, 64))


def test_every_link_inside_the_page_has_its_target() -> None:
    """Anchors, or headings as GitHub names them: lower case, punctuation dropped, spaces turned into hyphens."""
    headings = re.findall(r"^#+ (.*)$", TEXT, re.MULTILINE)
    targets = set(re.findall(r'<a id="(\w+)">', TEXT))
    targets |= {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}
    assert {target[1:] for _, target in LINKS if target.startswith("#")} <= targets


def test_every_name_stands_in_the_file_that_its_link_names() -> None:
    """Tests and functions alike: `name` linked to a Python file is defined in it; a law may be linked to its file."""

    def stands(name: str, path: Path) -> bool:
        return name in names_in(path) or (name in LAWS and path == ROOT / "plant" / "laws" / f"{name}.py")

    assert [link for link in CODE if not stands(link[0], (PAGE.parent / link[1]).resolve())] == []


def test_every_test_is_mentioned_with_a_link_to_its_file() -> None:
    linked = {name for name, target in CODE if target.startswith("../tests/")}
    assert set(re.findall(r"\btest_[a-z0-9]\w+\b(?!\.py)", TEXT)) == {name for name in linked if "test_" in name}
    assert len(linked) > 40


@pytest.mark.parametrize("anchor", ENTRIES)
def test_every_erratum_and_every_open_point_is_there_with_a_link_to_code(anchor: str) -> None:
    text = entry(anchor)
    number = anchor.upper()
    assert TEXT.count(f'<a id="{anchor}"></a>{number}') == 1
    assert re.search(r"\]\(\.\./(plant|objectives|tuner)/", text)


@pytest.mark.parametrize("anchor", [anchor for anchor in ENTRIES if anchor.startswith("e")])
def test_every_erratum_is_shown_by_tests_that_bear_its_number(anchor: str) -> None:
    """All of them, so a test that is added is added to the page."""
    number = f"test_e{int(anchor[1:]):02d}_"
    there = {
        name
        for path in (ROOT / "tests").rglob("test_errata_*.py")
        for name in names_in(path)
        if name.startswith(number)
    }
    assert there
    assert there == set(re.findall(rf"\[`({number}\w+)`\]\(\.\./tests/", entry(anchor)))


def test_the_laws_that_are_mentioned_can_be_flown() -> None:
    assert set(re.findall(LAW_NAME, TEXT)) <= set(LAWS)


def test_the_laws_that_come_from_the_paper_are_mentioned() -> None:
    assert {name for name, law in LAWS.items() if law.source.startswith("Wu et al.")} <= set(re.findall(LAW_NAME, TEXT))


def test_the_gains_of_the_hybrid_are_those_of_the_code() -> None:
    """Unit, default, range and scale in an attitude loop."""
    rows = re.findall(r"^\| `(\w+)` \| (\S.*?) \| (\S+) \| (\S+) to (\S+) \| (log|linear) \|", TEXT, re.MULTILINE)
    expected = []
    for gain in LAWS["hybrid"].gains:
        span = gain.span("attitude")
        expected.append(
            (gain.name.rstrip("_"), gain.unit_in("attitude"), span.default, span.low, span.high, gain.scale)
        )
    found = [
        (name, unit, float(middle), float(low), float(high), scale) for name, unit, middle, low, high, scale in rows
    ]
    assert found == expected


def test_places_for_figures_are_marked_once() -> None:
    for place in ("table3", "contest"):
        assert TEXT.count(f"<!-- {place} -->") == 1
