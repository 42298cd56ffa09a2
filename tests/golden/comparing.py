"""Differences between a kept output and a new one: one line a place, `path.to.key: old -> new`."""

import json
import re
from collections.abc import Iterator
from math import isclose
from pathlib import Path
from typing import Any

KEPT = Path(__file__).with_name("kept")
"""Folder of the kept outputs: json/ what commands print, results/ what runs leave, help/ what --help says."""
RELATIVE, ABSOLUTE = 1e-6, 1e-9
"""Tolerances of two numbers: another processor rounds otherwise, and that grows on the way through a flight."""
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
ABSENT = "(nothing)"
ADVICE = "If this is meant: python -m tests.golden.write, look at the diff, and commit it by itself."


def kept_names() -> list[str]:
    """Return the names of the kept files."""
    return sorted(path.relative_to(KEPT).as_posix() for path in KEPT.rglob("*") if path.is_file())


def kept(name: str) -> Any:
    """Return a kept document, or the text of a kept help."""
    text = (KEPT / name).read_text(encoding="utf-8")
    return json.loads(text) if name.endswith(".json") else text


def encoded(document: Any) -> str:
    """Return the text of a kept file."""
    return document if isinstance(document, str) else json.dumps(document, indent=1, ensure_ascii=False) + "\n"


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
