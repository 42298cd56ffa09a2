"""Files that people write, TOML or JSON, from text to table; what is no table at all is told with its line."""

import json
import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from plant.errors import InputError

DEEPEST = 16
"""Levels of tables and lists inside each other that are read; what anything here needs is 5."""
# Digits of a whole number; one of more has no place among floating-point numbers.
DIGITS = 300
# Characters before and behind the place of an error that are shown of a line.
SHOWN = 60


def toml_table(text: str, file: Path) -> dict[str, Any]:
    """Return the content of a TOML text; InputError, with the line where there is one, if it is none."""
    return _read(tomllib.loads, text, file, "TOML")


def json_table(text: str, file: Path) -> dict[str, Any]:
    """Return the content of a JSON text that holds an object; InputError, with the line where there is one, if it is none."""
    table = _read(json.loads, text, file, "JSON")
    if not isinstance(table, dict):
        raise InputError("holds no JSON object, which begins with {", file=file)
    return table


def _read(parse: Callable[[str], Any], text: str, file: Path, kind: str) -> Any:
    deep = f"is nested deeper than {DEEPEST} levels of tables and lists, which nothing here needs; take some out"
    long = f"not {kind} that can be read: a whole number in it has more than {DIGITS} digits"
    try:
        table = parse(text)
    except RecursionError:
        raise InputError(deep, file=file) from None
    except (tomllib.TOMLDecodeError, json.JSONDecodeError) as error:
        raise InputError(f"not {kind}: {error}{_line_of(text, str(error))}", file=file) from None
    except ValueError:
        # Python itself reads no whole number of more than 4300 digits.
        raise InputError(long, file=file) from None
    leaves, deeper = _leaves(table)
    if deeper:
        raise InputError(deep, file=file)
    if any(isinstance(leaf, int) and abs(leaf) >= 10**DIGITS for leaf in leaves):
        raise InputError(long, file=file)
    return table


def _line_of(text: str, message: str) -> str:
    """Return the line that a syntax error speaks of, ready to be put behind it."""
    lines, place = text.split("\n"), re.search(r"line (\d+),? column (\d+)", message)
    if place is None:
        return ""
    line, column = lines[int(place[1]) - 1], int(place[2])
    if len(line) > 2 * SHOWN:
        begin, end = max(column - SHOWN, 0), column + SHOWN
        line = f"{'... ' if begin else ''}{line[begin:end]}{' ...' if end < len(line) else ''}"
    return f"; correct this line: {line.strip()}"


def _leaves(table: Any) -> tuple[list[Any], bool]:
    """Return the values in nested tables and lists as deep as they are read, and whether it goes deeper."""
    leaves, layer = [], [table]
    for _ in range(DEEPEST):
        leaves += [value for value in layer if not isinstance(value, dict | list)]
        layer = [inner for value in layer for inner in _inside(value)]
    return leaves + layer, any(isinstance(value, dict | list) for value in layer)


def _inside(value: Any) -> list[Any]:
    if isinstance(value, dict):
        return list(value.values())
    return value if isinstance(value, list) else []
