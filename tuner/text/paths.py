"""Paths in a study's tables, and how to change all of them."""

from collections.abc import Callable
from copy import deepcopy
from typing import Any

Table = dict[str, Any]


def with_paths(table: Table, move: Callable[[str], str]) -> Table:
    """Return a study's content with every path in it put through `move`: of airframes, default gains, references."""
    result = deepcopy(table)
    holders = [result, *_tables(result.get("contender"))]
    for holder, key in [
        *[(holder.get("airframe"), "file") for holder in holders],
        *[(holder.get("controller"), "default") for holder in holders],
        *[(entry.get("reference"), "path") for entry in _tables(result.get("scenario"))],
    ]:
        if isinstance(holder, dict) and isinstance(holder.get(key), str):
            holder[key] = move(holder[key])
    return result


def _tables(entries: object) -> list[Table]:
    return [entry for entry in entries if isinstance(entry, dict)] if isinstance(entries, list) else []
