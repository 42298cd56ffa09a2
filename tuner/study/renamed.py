"""Keys of study files that have new names; the old ones are read for one release more, with a warning."""

import warnings
from collections.abc import Mapping
from pathlib import Path

from plant.errors import InputError
from plant.texts import PlainTable, PlainValue
from tuner.text.errors import RenamedKeyWarning

OF_LIMITS, OF_CHANNELS = {"most": "max", "least": "min"}, {"limit": "lost_beyond"}
NAMES = OF_LIMITS | OF_CHANNELS
"""Present names of old keys."""
RENAMED = {**dict.fromkeys(("constraint", "margin", "guarantee", "cost"), OF_LIMITS), "channel": OF_CHANNELS}
"""The same, by table."""
GONE = "0.3"
"""First version that does not read the old names."""
# Where a run keeps its study, which nobody is to edit.
RECORD = "run.json"


def with_new_names(table: Mapping[str, PlainValue], path: Path) -> PlainTable:
    """Return the content of a study with its keys' present names.

    path: the file that errors and warnings name. Raises InputError where a table has a key under both names.
    """
    renamed, result = [], dict(table)
    for name, names in RENAMED.items():
        entries = table.get(name)
        if isinstance(entries, list):
            result[name] = [
                _renamed(entry, names, f"{name}[{i}]", path, renamed) if isinstance(entry, Mapping) else entry
                for i, entry in enumerate(entries)
            ]
    if renamed and not (path.parent.parent / RECORD).is_file():
        news = " and ".join(new for old, new in NAMES.items() if any(key.endswith(f".{old}") for key in renamed))
        _warn(f"{path}: {', '.join(renamed)}: write {news}; version {GONE} does not read the old name")
    return result


def with_new_name(key: str) -> str:
    """Return the present name of a command line's dotted study key."""
    head, _, leaf = key.rpartition(".")
    new = next((names[leaf] for table, names in RENAMED.items() if head.startswith(table) and leaf in names), None)
    if new is None:
        return key
    _warn(f"{key}: write {new}; version {GONE} does not read the old name")
    return f"{head}.{new}"


def _renamed(
    entry: Mapping[str, PlainValue], names: Mapping[str, str], place: str, path: Path, renamed: list[str]
) -> PlainTable:
    for old, new in names.items():
        if old in entry and new in entry:
            raise InputError(
                f"this is the old name of {new}, which is given too; leave one out", file=path, key=f"{place}.{old}"
            )
    renamed += [f"{place}.{old}" for old in names if old in entry]
    return {names.get(key, key): value for key, value in entry.items()}


def _warn(message: str) -> None:
    warnings.warn(message, RenamedKeyWarning, stacklevel=2)
