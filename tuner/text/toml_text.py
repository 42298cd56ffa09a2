"""Tables of a study file as TOML text, with paths moved; a study put together from several files can stand alone."""

import json
import re
from collections.abc import Callable, Iterator, Mapping
from copy import deepcopy

from plant.texts import PlainTable, PlainValue

Table = Mapping[str, PlainValue]
SHIPPED = "shipped"
"""Entry of search.starts that is no path: the front that comes with the tool."""


def toml_text(table: Table) -> str:
    """Return a table as TOML; values are texts, numbers, truth values, lists and tables."""
    return "\n".join(_lines(table, ())) + "\n"


def _lines(table: Table, head: tuple[str, ...]) -> Iterator[str]:
    inner = {key: _tables_of(value) for key, value in table.items()}
    for key, value in table.items():
        if not inner[key]:
            yield f"{_key(key)} = {_value(value)}"
    for key, tables in inner.items():
        path = (*head, _key(key))
        for entry in tables:
            name = ".".join(path)
            yield ""
            yield f"[{name}]" if isinstance(table[key], Mapping) else f"[[{name}]]"
            yield from _lines(entry, path)


def _tables_of(value: PlainValue) -> list[Table]:
    """Return a table alone, or the entries of a list of tables; of any other value nothing."""
    entries = value if isinstance(value, list) else [value]
    tables = [entry for entry in entries if isinstance(entry, Mapping)]
    return tables if len(tables) == len(entries) else []


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else quoted(key)


def quoted(value: str) -> str:
    """Return a text as TOML writes it."""
    # A JSON string is a TOML basic string, but for the delete character, which TOML wants escaped.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")


def _value(value: PlainValue) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(_value(entry) for entry in value)}]"
    assert isinstance(value, int | float), f"{value!r} is no value of a study"
    return repr(value)


def shown(given: object) -> str:
    """Return a value as a study file writes it, or its beginning."""
    text = {True: "true", False: "false"}[given] if isinstance(given, bool) else repr(given)
    return text if len(text) <= 60 else text[:57] + "..."


def with_paths(table: PlainTable, move: Callable[[str], str]) -> PlainTable:
    """Return a study's content with every path put through `move`: of airframes, gains, starts, references, own code."""
    result = deepcopy(table)
    holders = [result, *tables_in(result.get("contender"))]
    for holder, key in [
        *[(holder.get("airframe"), "file") for holder in holders],
        *[(holder.get("controller"), "default") for holder in holders],
        *[(entry.get("reference"), "path") for entry in tables_in(result.get("scenario"))],
        *[(holder.get(table), "file") for holder in holders for table in ("law", "metric", "reference", "plant")],
        *[(holder.get("plant"), "fmu") for holder in holders],
        *[(holder.get("search"), "starts") for holder in holders],
    ]:
        given = holder.get(key) if isinstance(holder, dict) else None
        if isinstance(holder, dict) and isinstance(given, str):
            holder[key] = move(given)
        elif isinstance(holder, dict) and isinstance(given, list):
            holder[key] = [move(entry) if isinstance(entry, str) and entry != SHIPPED else entry for entry in given]
    return result


def tables_in(entries: PlainValue) -> list[PlainTable]:
    """Return the tables of a list; of any other value none."""
    return [entry for entry in entries if isinstance(entry, dict)] if isinstance(entries, list) else []
