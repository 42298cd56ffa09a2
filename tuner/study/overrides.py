"""Dotted keys of a contest: those of a study, and contender.NAME.KEY or contender.0.KEY."""

import re
from pathlib import Path
from typing import Any

from plant.errors import InputError, UnknownNameError
from tuner.study import reading


def put(table: dict[str, Any], key: str, value: Any, path: Path) -> None:
    """Set a key in the content of a contest; InputError where a contender or a list entry is not there."""
    asked = re.fullmatch(r"contender(?:\[(\d+)\]|\.(.+?))(?:\.(.*))?", key)
    if asked is None:
        reading.put(table, key, value, path)
        return
    entry, rest = _contender(table, key, path)
    if not rest:
        raise InputError(
            "names a contender, but none of its keys; write for instance contender.0.pick.rule", file=path, key=key
        )
    try:
        reading.put(entry, rest, value, path)
    except InputError as error:
        raise InputError(error.message, file=path, key=key) from None


def _contender(table: dict[str, Any], key: str, path: Path) -> tuple[dict[str, Any], str]:
    """Return a contender's table and what is left of the key; a name may hold dots, so the longest that fits is taken."""
    entries = table.get("contender")
    entries = entries if isinstance(entries, list) else []
    rest = re.sub(r"^\[(\d+)\]", r"\1", key.removeprefix("contender").removeprefix("."))
    number, _, behind = rest.partition(".")
    if number.isdecimal():
        if int(number) >= len(entries):
            raise InputError(f"there is no contender {number}; allowed: 0 to {len(entries) - 1}", file=path, key=key)
        return entries[int(number)], behind
    names = {str(entry.get("name")): entry for entry in entries}
    fitting = [name for name in names if rest == name or rest.startswith(f"{name}.")]
    if not fitting:
        raise UnknownNameError("contender", number, names, file=path, key=key)
    name = max(fitting, key=len)
    return names[name], rest[len(name) + 1 :]
