"""Counts of words and docstrings that break the rules of `CONTRIBUTING.md`, by rule and room; they may only fall.

`python -m tests.words` writes the counts of the tree to `tests/words.json`; `python -m tests.words RULE [ROOM]` lists places.
"""

import ast
import json
import re
import sys
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
TABLE = Path(__file__).with_suffix(".json")
PACKAGES = "plant", "objectives", "tuner"

# Words that say how a value was come by, or nothing: the value has a noun of its own.
BANNED_NAMES = frozenset("told asked said found known kept own whole beside apart again here there worth".split())
# Participles and metaphors for which the field has a term.
BANNED_CLASSES = frozenset(
    "Aboard Ability Aims AskedPart Asked Breach Brief Chances Craft Different Drawing Extent Finding Fittings Foresight "
    "Halving Held HeldError Hope Judged Kept Known Mix Moved Mover Nothing Orders Paced Prepared Question Searched Sheet "
    "Sortie Spared Spent Story Surroundings Swing Told Together Trust TwoWays Unhurried Wired Wish Worth".split()
)
# American spelling, as SciPy has it.
BRITISH = re.compile(
    r"(?:colour|behaviour|neighbour|favour|centre|modell(?:ed|ing)|labell(?:ed|ing))s?|[a-z]{4,}is(?:e[ds]?|er|ing|ation)"
)
SAME_IN_BOTH = (
    "noise",
    "raise",
    "promis",
    "premise",
    "precis",
    "concis",
    "otherwis",
    "advis",
    "revis",
    "supervis",
    "surpris",
    "exercis",
)
MAX_WORDS = 12
FUNCTIONS = ast.FunctionDef, ast.AsyncFunctionDef

Documented = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


class Place(NamedTuple):
    """A place that breaks a rule."""

    rule: str
    line: int
    text: str


def places(tree: ast.Module) -> Iterator[Place]:
    """Yield the places of a module that break a rule."""
    for node in ast.walk(tree):
        yield from _names(node)
        if isinstance(node, ast.Module | ast.ClassDef | FUNCTIONS[0] | FUNCTIONS[1]):
            yield from _docstring(node)


def _names(node: ast.AST) -> Iterator[Place]:
    line = getattr(node, "lineno", 1)
    for name in _bound(node):
        if name.lower().strip("_") in BANNED_NAMES:
            yield Place("banned name", line, name)
        if any(map(_is_british, re.findall(r"[a-z]+|[A-Z][a-z]+", name))):
            yield Place("British spelling", line, name)
    if isinstance(node, ast.ClassDef) and node.name.strip("_") in BANNED_CLASSES:
        yield Place("banned class", line, node.name)


def _is_british(word: str) -> bool:
    return bool(BRITISH.fullmatch(word.lower())) and not word.lower().startswith(SAME_IN_BOTH)


def _bound(node: ast.AST) -> list[str]:
    """Return the names that a node binds."""
    match node:
        case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) | ast.ClassDef(name=name) | ast.arg(arg=name):
            return [name]
        case ast.Name(id=name, ctx=ast.Store()) | ast.Attribute(attr=name, ctx=ast.Store()):
            return [name]
        case ast.alias(asname=str(name)):
            return [name]
    return []


def _docstring(node: Documented) -> Iterator[Place]:
    text = ast.get_docstring(node)
    if not text:
        return
    line, first = getattr(node, "lineno", 1), text.split("\n")[0]
    if not isinstance(node, ast.Module) and re.match(r"Return (?:what|how|whether|where|which|who)\b", first):
        yield Place("Return what", line, first)
    # Shapes and units are no words.
    clause = re.sub(r"\([^()]*\)|\[[^\[\]]*\]|\{[^{}]*\}", "", re.split(r"[:;.](?:\s|$)", first)[0])
    if len(clause.split()) > MAX_WORDS:
        yield Place("long first line", line, first)
    if _is_chain(text, _parameters(node)):
        yield Place("chained parameters", line, first)


def _parameters(node: Documented) -> list[str]:
    """Return the names of a function's arguments, or of a class's fields and arguments."""
    if isinstance(node, FUNCTIONS):
        return [argument.arg for argument in ast.walk(node.args) if isinstance(argument, ast.arg)]
    names: list[str] = []
    for child in node.body if isinstance(node, ast.ClassDef) else []:
        if isinstance(child, ast.AnnAssign) and isinstance(child.target, ast.Name):
            names.append(child.target.id)
        elif isinstance(child, ast.FunctionDef) and child.name == "__init__":
            names += _parameters(child)
    return names


def _is_chain(text: str, names: list[str]) -> bool:
    """Return True if three parameters or more are described one after another in a line of running text."""
    if len(names) < 3:
        return False
    name = f"`?(?:{'|'.join(names)})`?"
    described = re.compile(rf"(?:^|[;.:] |\n *){name}(?:, {name})*(?: \([^()]*\)| \[[^\]]*\])*: ")
    starts = [match[0] for match in described.finditer(text)]
    return len(starts) >= 3 and any("\n" not in start for start in starts[1:])


@cache
def places_by_room() -> dict[tuple[str, str], list[str]]:
    """Return the places of the product by rule and room (`tuner/search`, or `plant` for its loose files)."""
    out: dict[tuple[str, str], list[str]] = {}
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            name = path.relative_to(ROOT)
            room = "/".join(name.parts[:-1][:2])
            for rule, line, text in places(ast.parse(path.read_text(encoding="utf-8"))):
                out.setdefault((rule, room), []).append(f"{name}:{line}: {text}")
    return out


def counts() -> dict[str, dict[str, int]]:
    """Return the counts by rule, then by room."""
    table: dict[str, dict[str, int]] = {}
    for (rule, room), lines in sorted(places_by_room().items()):
        table.setdefault(rule, {})[room] = len(lines)
    return table


def recorded() -> dict[str, dict[str, int]]:
    """Return the counts of `tests/words.json`."""
    return json.loads(TABLE.read_text(encoding="utf-8"))


def differences(table: dict[str, dict[str, int]], counted: dict[str, dict[str, int]], places: dict) -> list[str]:
    """Return a line for each count that differs from the table's, with the places where it rose."""
    lines = []
    for rule in sorted({*table, *counted}):
        before, now = Counter(table.get(rule, {})), Counter(counted.get(rule, {}))
        for room in sorted({*before, *now}):
            if now[room] > before[room]:
                listed = "\n  ".join(places[rule, room])
                lines.append(f"{rule} in {room}: {now[room]}, at most {before[room]} allowed:\n  {listed}")
            elif now[room] < before[room]:
                lines.append(f"{rule} in {room}: {now[room]}, down from {before[room]}; run `python -m tests.words`")
    return lines


def main(arguments: list[str]) -> None:
    """Write the table, or list the places of a rule, and of a room if one is named."""
    if not arguments:
        TABLE.write_text(json.dumps(counts(), indent=1) + "\n", encoding="utf-8")
        for rule, rooms in counts().items():
            print(f"{rule}: {sum(rooms.values())}")
    for (rule, room), lines in places_by_room().items():
        if arguments and rule == arguments[0] and room.startswith(tuple(arguments[1:]) or ""):
            print(*lines, sep="\n")


if __name__ == "__main__":
    main(sys.argv[1:])
