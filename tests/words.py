"""Counts of words and sentences that break the rules of `CONTRIBUTING.md`, by rule and room; they may only fall.

`python -m tests.words` writes the counts of the tree to `tests/words.json`; `python -m tests.words RULE [ROOM]` lists places.
"""

import ast
import json
import re
import sys
from collections import Counter
from collections.abc import Iterator
from functools import cache
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple

from tests import sentences
from tests.sources import sources, walk

ROOT = Path(__file__).parents[1]
TABLE = Path(__file__).with_suffix(".json")
# The changelog is history.
PAGES = "README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md", "docs/**/*.md", "tuner/extensions/*/README.md"

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
# A constant is a noun: bounds have prefixes of their own, and no last word is an adjective or a participle.
BOUND_WITHOUT_TERM = re.compile(r"_*(?:LEAST|MOST|FEWEST|LOWEST|HIGHEST|LARGEST|SMALLEST|LONGEST)_")
NOT_NOUN = re.compile(
    r"SMALL|LARGE|BIG|NEAR|NEARLY|FAR|MANY|FEW|MORE|LESS|OWN|KNOWN|GIVEN|DRAWN|SHOWN|TAKEN|FORGIVEN|HIDDEN|LEFT|HELD|"
    r"KEPT|MADE|WIDE|NARROW|TOGETHER|LEAST|MOST|FEWEST|(?!SEED|SPEED|FEED|NEED|RED)\w*ED|(?!REST|TEST|REQUEST|DIGEST|MANIFEST)\w+EST"
)
FUNCTIONS = ast.FunctionDef, ast.AsyncFunctionDef

DOCUMENTED = (ast.Module, ast.ClassDef, *FUNCTIONS)
BINDING = (ast.Name, ast.Attribute, ast.arg, ast.alias, ast.ClassDef, *FUNCTIONS)

Documented = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


class Place(NamedTuple):
    """A place that breaks a rule."""

    rule: str
    line: int
    text: str


def places(tree: ast.Module) -> Iterator[Place]:
    """Yield the places of a module that break a rule."""
    nodes = list(walk(tree))
    for node in nodes:
        if isinstance(node, BINDING):
            yield from _names(node)
        if isinstance(node, DOCUMENTED):
            yield from _docstring(node)
            if not isinstance(node, FUNCTIONS):
                yield from _constants(node.body)
    for line, text in sentences.messages(nodes):
        yield from (Place(rule, line, sentence) for rule, sentence in sentences.faults(text))


def _constants(body: list[ast.stmt]) -> Iterator[Place]:
    """Yield the faults of the constants of a module or a class, and of the strings that document values."""
    for statement, following in zip_longest(body, body[1:]):
        bound = _bindings(statement)
        names = [name for name in bound if name.isupper()]
        for name in names:
            if BOUND_WITHOUT_TERM.match(name) or (
                NOT_NOUN.fullmatch(name.rpartition("_")[2]) and not _is_label(bound[name])
            ):
                yield Place("constant without noun", statement.lineno, name)
        if not bound or not isinstance(following, ast.Expr) or not isinstance(following.value, ast.Constant):
            continue
        line, text = following.lineno, str(following.value.value)
        if len(names) > 1:
            yield Place("constants together", line, ", ".join(names))
        if sentences.is_headless(text):
            yield Place("headless description", line, text)
        yield from (Place(rule, line, sentence) for rule, sentence in sentences.faults(sentences.prose(text)))


def _bindings(statement: ast.stmt) -> dict[str, ast.expr | None]:
    """Return the names that an assignment binds, with their values where these stand there."""
    match statement:
        case ast.Assign(targets=[ast.Tuple(elts=names)], value=ast.Tuple(elts=values)) if len(names) == len(values):
            pairs = list(zip(names, values, strict=True))
        case ast.Assign(targets=targets, value=value):
            pairs = [(node, value) for target in targets for node in ast.walk(target)]
        case ast.AnnAssign(target=target, value=value):
            pairs = [(target, value)]
        case _:
            pairs = []
    return {node.id: value for node, value in pairs if isinstance(node, ast.Name)}


def _is_label(value: ast.expr | None) -> bool:
    """Return True if a constant is a state's name, for which a participle is right."""
    return isinstance(value, ast.Attribute) or (isinstance(value, ast.Constant) and isinstance(value.value, str))


def _names(node: ast.AST) -> Iterator[Place]:
    line = getattr(node, "lineno", 1)
    for name in _bound(node):
        if name.lower().strip("_") in BANNED_NAMES:
            yield Place("banned name", line, name)
        if any(map(_is_british, re.findall(r"[a-z]+|[A-Z][a-z]+", name))):
            yield Place("British spelling", line, name)
    if isinstance(node, ast.ClassDef) and node.name.strip("_") in BANNED_CLASSES:
        yield Place("banned class", line, node.name)


@cache
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
    yield from (Place("headless description", line, d) for d in sentences.entries(text) if sentences.is_headless(d))
    yield from (Place(rule, line, sentence) for rule, sentence in sentences.faults(sentences.prose(text)))


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
    # Each description has a colon: most texts are done before a pattern is made of the names.
    if len(names) < 3 or text.count(": ") < 3:
        return False
    name = f"`?(?:{'|'.join(names)})`?"
    described = re.compile(rf"(?:^|[;.:] |\n *){name}(?:, {name})*(?: \([^()]*\)| \[[^\]]*\])*: ")
    starts = [match[0] for match in described.finditer(text)]
    return len(starts) >= 3 and any("\n" not in start for start in starts[1:])


@cache
def places_by_room() -> dict[tuple[str, str], list[str]]:
    """Return the places of the product by rule and room (`tuner/search`, or `plant` for its loose files)."""
    out: dict[tuple[str, str], list[str]] = {}
    for name, source in sources():
        room = "/".join(name.split("/")[:-1][:2])
        for rule, line, text in places(ast.parse(source)):
            out.setdefault((rule, room), []).append(f"{name}:{line}: {text}")
    for path in sorted(path for pattern in PAGES for path in ROOT.glob(pattern)):
        name = path.relative_to(ROOT)
        for rule, text in sentences.faults(sentences.markdown_prose(path.read_text(encoding="utf-8"))):
            out.setdefault((rule, "/".join(name.parts[:-1][:2]) or str(name)), []).append(f"{name}: {text}")
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
