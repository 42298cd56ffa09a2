"""Files that people write, TOML or JSON, from text to table; and the one rule each for the names and the texts in them.

A name stands in file names and in exported code. A text (a title, the source of a number) is read by people: one line of letters
that print, so neither line breaks nor escape sequences nor marks that turn the direction of writing.
"""

import json
import re
import signal
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from datetime import date, time
from pathlib import Path
from typing import Any, TypeAlias

from plant.errors import InputError, one_line, shortened
from plant.input_files import check_json_size

PlainValue: TypeAlias = (
    None | bool | int | float | str | date | time | Sequence["PlainValue"] | Mapping[str, "PlainValue"]
)
"""A value of a TOML or JSON file, read or to be written; a reader of one finds out which it is before it uses it."""
PlainTable: TypeAlias = dict[str, PlainValue]
"""Content of such a file, or one of its tables."""
DEEPEST = 16
"""Levels of tables and lists inside each other that are read; what anything here needs is 5."""
# Digits of a whole number; one of more has no place among floating-point numbers.
DIGITS = 300
# Characters before and behind the place of an error that are shown of a line.
SHOWN = 60

NAME = r"[A-Za-z0-9]([A-Za-z0-9 ._-]{0,62}[A-Za-z0-9._-])?"
"""Regular expression of a whole name."""
NAMES = "1 to 64 letters (a to z, A to Z), digits, spaces and - _ . with a letter or digit in front and no space behind"
LONGEST_TITLE, LONGEST_TEXT = 200, 2000
# Keys whose texts may have several lines.
PROSE = ("description",)


def inert(text: str) -> str:
    """Return a text with unprintable characters as JSON escapes, but for line breaks and tabs."""
    if text.isascii() and text.replace("\n", "").replace("\t", "").isprintable():
        return text
    return "".join(
        letter if letter.isprintable() or letter in "\n\t" else json.dumps(letter)[1:-1].replace("\x7f", "\\u007f")
        for letter in text
    )


def check_name(name: str, *, file: Path | None = None, key: str | None = None) -> None:
    """Refuse what is no name; raises InputError with what was given and what is allowed."""
    if not re.fullmatch(NAME, name):
        message = f"given '{shortened(one_line(name))}'; a name is {NAMES}: give it another"
        raise InputError(message, file=file, key=key)


def check_text(text: str, longest: int = LONGEST_TEXT, *, file: Path | None = None, key: str | None = None) -> None:
    """Raise InputError for a text that is long or does not print on one line."""
    odd = next((letter for letter in text if not letter.isprintable()), None)
    if odd is not None:
        message = f"holds the character U+{ord(odd):04X}; a text is one line of letters that print: take it out"
        raise InputError(message, file=file, key=key)
    if len(text) > longest:
        message = f"has {len(text):,} letters; allowed: up to {longest:,}: shorten it"
        raise InputError(message, file=file, key=key)


def check_title(title: str, *, file: Path | None = None, key: str | None = None) -> None:
    """Refuse an empty, long or unprintable title; raises InputError."""
    if not title.strip():
        raise InputError("given an empty text; write a title that says what this is", file=file, key=key)
    check_text(title, LONGEST_TITLE, file=file, key=key)


def check_texts(table: PlainValue, *, file: Path | None = None) -> None:
    """Refuse a text anywhere in nested tables and lists that `check_text` refuses; raises InputError with its key."""
    for key, text in texts_in(table):
        lines = text.replace("\t", " ").splitlines() if key.split(".")[-1] in PROSE else [text]
        for line in lines:
            check_text(line, file=file, key=key)


def texts_in(table: Any) -> Iterator[tuple[str, str]]:
    """Yield dotted key and text of all texts in nested tables."""
    return ((key, value) for key, value in values_in(table) if isinstance(value, str))


def values_in(table: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """Yield dotted key and value of all leaves of nested tables.

    key: of the table itself.
    """
    if isinstance(table, dict):
        for name, inner in table.items():
            yield from values_in(inner, f"{key}.{name}" if key else str(name))
    elif isinstance(table, list):
        for i, inner in enumerate(table):
            yield from values_in(inner, f"{key}[{i}]")
    else:
        yield key, table


def signal_name(number: int) -> str:
    """Return the name of a signal, "signal 35" of one without."""
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


def toml_table(text: str, file: Path) -> PlainTable:
    """Return the content of a TOML text; InputError, with the line where there is one, if it is none."""
    return _read(tomllib.loads, text, file, "TOML")


def json_table(text: str, file: Path) -> PlainTable:
    """Return the content of a JSON text that holds an object; InputError, with the line where there is one, if it is none."""
    try:
        check_json_size(text)
    except ValueError as error:
        raise InputError(f"is {error}", file=file) from None
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
        # From Python 3.14 on thousands of brackets are read up to the first mistake behind them.
        if _nesting(text) > DEEPEST:
            raise InputError(deep, file=file) from None
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


def _nesting(text: str) -> int:
    """Return the depth of nested brackets outside of quoted texts."""
    depth = deepest = 0
    for part in re.finditer(r'"(?:\\.|[^"\\])*"|[\[{]|[\]}]', text):
        depth += {"[": 1, "{": 1, "]": -1, "}": -1}.get(part[0], 0)
        deepest = max(deepest, depth)
    return deepest


def _line_of(text: str, message: str) -> str:
    """Return the line of a syntax error, to be appended to its message."""
    lines, place = text.split("\n"), re.search(r"line (\d+),? column (\d+)", message)
    if place is None:
        return ""
    line, column = lines[int(place[1]) - 1], int(place[2])
    if len(line) > 2 * SHOWN:
        begin, end = max(column - SHOWN, 0), column + SHOWN
        line = f"{'... ' if begin else ''}{line[begin:end]}{' ...' if end < len(line) else ''}"
    return f"; correct this line: {line.strip()}"


def _leaves(table: PlainValue) -> tuple[list[PlainValue], bool]:
    """Return the values in nested tables and lists up to `DEEPEST`, and True if deeper ones exist."""
    leaves: list[PlainValue] = []
    layer = [table]
    for _ in range(DEEPEST):
        leaves += [value for value in layer if not isinstance(value, dict | list)]
        layer = [inner for value in layer for inner in _inside(value)]
    return leaves + layer, any(isinstance(value, dict | list) for value in layer)


def _inside(value: PlainValue) -> list[PlainValue]:
    if isinstance(value, dict):
        return list(value.values())
    return value if isinstance(value, list) else []
