"""The paths in a study's tables: where they stand, and how to change all of them."""

from collections.abc import Callable
from copy import deepcopy
from typing import Any

Table = dict[str, Any]


def with_paths(table: Table, move: Callable[[str], str]) -> Table:
    """Return a study's content with every path in it put through `move`: airframe.file, path of a reference."""
    result = deepcopy(table)
    frames = [result.get("airframe"), *[c.get("airframe") for c in _tables(result.get("contender"))]]
    for holder, key in [
        *[(frame, "file") for frame in frames],
        *[(entry.get("reference"), "path") for entry in _tables(result.get("scenario"))],
    ]:
        if isinstance(holder, dict) and isinstance(holder.get(key), str):
            holder[key] = move(holder[key])
    return result


def _tables(entries: object) -> list[Table]:
    return [entry for entry in entries if isinstance(entry, dict)] if isinstance(entries, list) else []
