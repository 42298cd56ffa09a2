"""Keys of study files that have new names; the old ones are read for one release more, with a warning."""

import warnings
from collections.abc import Mapping
from pathlib import Path

from plant.errors import InputError
from plant.texts import PlainTable, PlainValue
from tuner.text.errors import RenamedKeyWarning

RENAMED = {"most": "max", "least": "min"}
GONE = "0.3"
"""First version that does not read the old names."""
TABLES = ("constraint", "margin", "guarantee", "cost")
# Where a run keeps its study, which nobody is to edit.
RECORD = "run.json"


def with_new_names(table: Mapping[str, PlainValue], path: Path) -> PlainTable:
    """Return the content of a study with its keys' present names.

    path: the file that errors and warnings name. Raises InputError where a table has a key under both names.
    """
    renamed, result = [], dict(table)
    for name in TABLES:
        entries = table.get(name)
        if isinstance(entries, list):
            result[name] = [
                _renamed(entry, f"{name}[{i}]", path, renamed) if isinstance(entry, Mapping) else entry
                for i, entry in enumerate(entries)
            ]
    if renamed and not (path.parent.parent / RECORD).is_file():
        news = " and ".join(new for old, new in RENAMED.items() if any(key.endswith(f".{old}") for key in renamed))
        _warn(f"{path}: {', '.join(renamed)}: write {news}; version {GONE} does not read the old name")
    return result


def with_new_name(key: str) -> str:
    """Return the present name of a command line's dotted study key."""
    head, _, leaf = key.rpartition(".")
    if leaf not in RENAMED or not head.startswith(TABLES):
        return key
    _warn(f"{key}: write {RENAMED[leaf]}; version {GONE} does not read the old name")
    return f"{head}.{RENAMED[leaf]}"


def _renamed(entry: Mapping[str, PlainValue], place: str, path: Path, renamed: list[str]) -> PlainTable:
    for old, new in RENAMED.items():
        if old in entry and new in entry:
            raise InputError(
                f"this is the old name of {new}, which is given too; leave one out", file=path, key=f"{place}.{old}"
            )
    renamed += [f"{place}.{old}" for old in RENAMED if old in entry]
    return {RENAMED.get(key, key): value for key, value in entry.items()}


def _warn(message: str) -> None:
    warnings.warn(message, RenamedKeyWarning, stacklevel=2)
