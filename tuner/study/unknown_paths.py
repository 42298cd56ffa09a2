"""Dotted paths into the tables of a contest: "contender.ADRC.gains.attitude.omega_c", "scenario.0.air.window.1".

The entries of [[contender]] go by name, those of other lists by number, from 0; the keys of [gains] hold a dot themselves.
A path may end at a key that does not stand there yet, in tables that do not either, but not in a list that does not.
"""

from typing import Any

from plant.errors import InputError, UnknownNameError
from plant.texts import PlainTable

CONTENDER, GAINS = "contender", "gains"
Place = tuple[str | int, ...]
"""The keys and list indices that lead from the top of the tables to one value."""


def place_of(table: PlainTable, path: str) -> Place:
    """Return the place that a path leads to; InputError, without file and key, where there can be none."""
    place: list[str | int] = []
    level: Any = table
    rest = path
    while rest:
        part, rest = _next(level, place, rest)
        place.append(part)
        level = _below(level, part, path, last=not rest)
    if not place or isinstance(level, dict | list):
        kind = "nothing" if not place else _kind(level)
        raise InputError(f"'{path}' leads to {kind}; a path leads to one number{_below_hint(level)}")
    return tuple(place)


def value_at(table: Any, place: Place) -> Any:
    """Return the value at a place, None where there is none."""
    level = table
    for part in place:
        if isinstance(level, dict):
            level = level.get(part)
        elif isinstance(level, list) and isinstance(part, int):
            level = level[part]
        else:
            return None
    return level


def put_at(table: Any, place: Place, value: float) -> None:
    """Set a place of nested tables and lists, with missing tables added."""
    *parents, last = place
    level = table
    for part in parents:
        level = level.setdefault(part, {}) if isinstance(level, dict) else level[part]
    level[last] = value


def _next(level: Any, before: list[str | int], rest: str) -> tuple[str | int, str]:
    """Return a path's next part, key or index, and the rest."""
    if isinstance(level, list):
        return _index(level, before, rest)
    if before and before[-1] == GAINS and rest.count(".") >= 1:
        axis, name, *more = rest.split(".", 2)
        return f"{axis}.{name}", more[0] if more else ""
    part, _, left = rest.partition(".")
    return part, left


def _index(level: list[Any], before: list[str | int], rest: str) -> tuple[int, str]:
    """Return the index of a list entry: a number, or the name of a contender, which may hold dots."""
    if before == [CONTENDER]:
        names = [str(entry.get("name")) for entry in level]
        fitting = [name for name in names if rest == name or rest.startswith(f"{name}.")]
        if not fitting:
            raise UnknownNameError("contender", rest.split(".")[0], names)
        name = max(fitting, key=len)
        return names.index(name), rest[len(name) + 1 :]
    part, _, left = rest.partition(".")
    if not part.isdecimal() or int(part) >= len(level):
        allowed = f"0 to {len(level) - 1}" if level else "none, the list is empty"
        raise InputError(f"'{part}' is no entry of the list '{'.'.join(map(str, before))}'; allowed: {allowed}")
    return int(part), left


def _below(level: Any, part: str | int, path: str, last: bool) -> Any:
    """Return the content below a part; an empty table for one that is missing on the way, None at the end of it."""
    if isinstance(level, list):
        assert isinstance(part, int)
        return level[part]
    if part in level:
        below = level[part]
        if not last and not isinstance(below, dict | list):
            raise InputError(f"'{path}' goes on behind '{part}', which is a value; end the path there")
        return below
    return None if last else {}


def _kind(level: Any) -> str:
    return "a list" if isinstance(level, list) else "a table"


def _below_hint(level: Any) -> str:
    """Return the end of the message on a path without a value."""
    if isinstance(level, list) and level:
        return f"; go on with an entry, 0 to {len(level) - 1}"
    if isinstance(level, dict) and level:
        return f"; there is: {', '.join(map(str, level))}"
    return ""
