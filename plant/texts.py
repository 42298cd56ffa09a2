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
    try:
        table = parse(text)
    except RecursionError:
        raise InputError(deep, file=file) from None
    except (tomllib.TOMLDecodeError, json.JSONDecodeError) as error:
        raise InputError(f"not {kind}: {error}{_line_of(text, str(error))}", file=file) from None
    except ValueError as error:
        # A whole number of thousands of digits, which Python refuses to read.
        raise InputError(f"not {kind} that can be read: {error}", file=file) from None
    if _deeper(table, DEEPEST):
        raise InputError(deep, file=file)
    return table


def _line_of(text: str, message: str) -> str:
    """Return the line that a syntax error speaks of, ready to be put behind it."""
    lines, number = text.split("\n"), re.search(r"line (\d+)", message)
    if number is None or int(number[1]) > len(lines):
        return ""
    line = lines[int(number[1]) - 1].strip()
    return f"; correct this line: {line if len(line) <= 120 else f'{line[:117]}...'}"


def _deeper(value: Any, levels: int) -> bool:
    """Return whether tables and lists are nested deeper than so many levels."""
    layer = [value]
    for _ in range(levels):
        layer = [inner for outer in layer for inner in _inside(outer)]
    return any(isinstance(inner, dict | list) for inner in layer)


def _inside(value: Any) -> list[Any]:
    if isinstance(value, dict):
        return list(value.values())
    return value if isinstance(value, list) else []
