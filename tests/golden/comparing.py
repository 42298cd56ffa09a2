"""Differences between a kept output and a new one: one line a place, `path.to.key: old -> new`.

Kept files are folded, without loss: a part that an earlier file holds is a reference to it, rows with the same keys are a table
of a line a row, and what fits into a line is one. `kept` unfolds them.
"""

import json
import re
from collections.abc import Iterator, Mapping
from functools import cache, reduce
from math import isclose
from pathlib import Path
from typing import Any

KEPT = Path(__file__).with_name("kept")
"""Folder of the kept outputs: json/ what commands print, results/ what runs leave, help/ what --help says."""
RELATIVE, ABSOLUTE = 1e-6, 1e-9
"""Tolerances of two numbers: another processor rounds otherwise, and that grows on the way through a flight."""
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
ABSENT = "(nothing)"
SAME, COLUMNS, ROWS = "#same", "#columns", "#rows"
"""Keys of what a kept file has in place of a part: the place of the same part before it, or a table."""
LONG_PART, LINE = 150, 120
"""Letters from which on a part is kept once, and of a line."""
ADVICE = "If this is meant: python -m tests.golden.write, look at the diff, and commit it by itself."


def kept_names() -> list[str]:
    """Return the names of the kept files."""
    return sorted(path.relative_to(KEPT).as_posix() for path in KEPT.rglob("*") if path.is_file())


def kept(name: str) -> Any:
    """Return a kept document, or the text of a kept help."""
    return unfolded(content(name))


@cache
def content(name: str) -> Any:
    """Return the content of a kept file, as it is folded."""
    text = (KEPT / name).read_text(encoding="utf-8")
    return json.loads(text) if name.endswith(".json") else text


def folded(documents: Mapping[str, Any]) -> dict[str, Any]:
    """Return documents by name, in order, with a reference in place of each long part that stands before it."""
    places: dict[str, list[Any]] = {}
    return {
        name: value if isinstance(value, str) else _folded(value, [name], places) for name, value in documents.items()
    }


def _folded(value: Any, place: list[Any], places: dict[str, list[Any]]) -> Any:
    if not isinstance(value, dict | list):
        return value
    text = json.dumps(value, ensure_ascii=False)
    if len(text) >= LONG_PART and places.setdefault(text, place) != place:
        return {SAME: places[text]}
    if isinstance(value, dict):
        return {key: _folded(entry, [*place, key], places) for key, entry in value.items()}
    entries = [_folded(entry, [*place, index], places) for index, entry in enumerate(value)]
    names = list(entries[0]) if entries and isinstance(entries[0], dict) else []
    if len(entries) < 2 or len(names) < 2 or any(not isinstance(row, dict) or list(row) != names for row in entries):
        return entries
    return {COLUMNS: names, ROWS: [list(row.values()) for row in entries]}


def unfolded(value: Any) -> Any:
    """Return the document that `folded` was given."""
    if isinstance(value, list):
        return [unfolded(entry) for entry in value]
    if not isinstance(value, dict):
        return value
    if SAME in value:
        return unfolded(_referenced(value))
    if COLUMNS in value:
        return [dict(zip(value[COLUMNS], map(unfolded, row), strict=True)) for row in value[ROWS]]
    return {key: unfolded(entry) for key, entry in value.items()}


def _referenced(value: dict[str, Any]) -> Any:
    """Return the folded part that a reference names."""
    name, *keys = value[SAME]
    return reduce(_entry, keys, content(name))


def _entry(part: Any, key: Any) -> Any:
    """Return an entry of a folded part; a reference is followed, a row of a table gets its names."""
    if isinstance(part, dict) and SAME in part:
        part = _referenced(part)
    if isinstance(part, dict) and COLUMNS in part:
        return dict(zip(part[COLUMNS], part[ROWS][key], strict=True))
    return part[key]


def encoded(document: Any) -> str:
    """Return the text of a kept file."""
    return document if isinstance(document, str) else _encoded(document, 0) + "\n"


def _encoded(value: Any, depth: int) -> str:
    flat = json.dumps(value, ensure_ascii=False)
    if not isinstance(value, dict | list) or not value or len(flat) + depth <= LINE:
        return flat
    before, after = "{}" if isinstance(value, dict) else "[]"
    if isinstance(value, dict):
        parts = [
            f"{json.dumps(key, ensure_ascii=False)}: {_part(key, entry, depth + 1)}" for key, entry in value.items()
        ]
    else:
        parts = [_encoded(entry, depth + 1) for entry in value]
    lines = ",\n".join(" " * (depth + 1) + part for part in parts)
    return f"{before}\n{lines}\n{' ' * depth}{after}"


def _part(key: str, value: Any, depth: int) -> str:
    """Return an entry of a document; the rows of a table whose cells are numbers and texts a line each, however long."""
    if key != ROWS or any(isinstance(cell, dict | list) for row in value for cell in row):
        return _encoded(value, depth)
    rows = ",\n".join(" " * (depth + 1) + json.dumps(row, ensure_ascii=False) for row in value)
    return f"[\n{rows}\n{' ' * depth}]"


def differences(old: Any, new: Any, path: str = "") -> Iterator[str]:
    """Yield a line for each place where two documents differ."""
    if isinstance(old, dict) and isinstance(new, dict):
        for key in [*old, *(key for key in new if key not in old)]:
            yield from differences(old.get(key, ABSENT), new.get(key, ABSENT), f"{path}.{key}".removeprefix("."))
    elif isinstance(old, list) and isinstance(new, list):
        for index in range(max(len(old), len(new))):
            here, there = (entries[index] if index < len(entries) else ABSENT for entries in (old, new))
            yield from differences(here, there, f"{path}[{index}]")
    elif not same(old, new):
        yield f"{path}: {said(old)} -> {said(new)}"


def same(old: Any, new: Any) -> bool:
    """Return whether two leaves are the same; numbers, in sentences as well, within the tolerances."""
    if isinstance(old, str) and isinstance(new, str):
        return NUMBER.split(old) == NUMBER.split(new) and all(
            near(float(here), float(there))
            for here, there in zip(NUMBER.findall(old), NUMBER.findall(new), strict=True)
        )
    if any(isinstance(value, bool) or not isinstance(value, int | float) for value in (old, new)):
        return type(old) is type(new) and old == new
    return near(float(old), float(new))


def near(old: float, new: float) -> bool:
    """Return whether two numbers are equal within the tolerances; not-a-number equals itself."""
    return isclose(old, new, rel_tol=RELATIVE, abs_tol=ABSOLUTE) or (old != old and new != new)


def said(value: Any) -> str:
    """Return a value as one short text."""
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 200 else f"{text[:200]} ..."


def updated(old: Any, new: Any) -> Any:
    """Return the new document with the old digits where numbers agree, so that a diff shows what has changed and no more."""
    if isinstance(old, dict) and isinstance(new, dict):
        return {key: updated(old[key], entry) if key in old else entry for key, entry in new.items()}
    if isinstance(old, list) and isinstance(new, list):
        return [updated(old[i], entry) if i < len(old) else entry for i, entry in enumerate(new)]
    return old if same(old, new) else new
