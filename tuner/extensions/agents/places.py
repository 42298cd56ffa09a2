"""Places that a call names: each has to lie in the root, whatever links lead to it or lie in it."""

import os
from collections.abc import Iterator
from pathlib import Path

from plant.errors import InputError
from plant.texts import texts_in
from tuner.cli.app import TextKind, parse_changes

MAX_DEPTH = 3
"""Levels of a folder in which links are looked for; no results folder is deeper."""


def check_text(text: str, label: str, kind: TextKind | None, root: Path, bases: list[Path]) -> None:
    """Raise InputError for a text that names a place outside.

    Args:
        text: text as given.
        label: name of the parameter.
        kind: kind of the text.
        root: folder, links resolved.
        bases: further folders that names in a change are relative to.
    """
    for place in filter(None, places_in(text, kind)):
        for base in [root, *(bases if kind is TextKind.CHANGE else ())]:
            check_place(place, label, root, base)


def places_in(text: str, kind: TextKind | None) -> Iterator[str]:
    """Yield all texts that a command could open for a text."""
    if kind is TextKind.LOG:
        yield from (text, text.rpartition("@")[0])
    elif kind is TextKind.CHANGE:
        yield text.partition("=")[2]
        yield from (inner for _, inner in texts_in(parse_changes([text])))
    else:
        # A study may be named without its ending.
        yield from (text, f"{text}.toml")


def check_place(text: str, label: str, root: Path, base: Path | None = None) -> None:
    """Raise InputError for a place outside, or with a link outside.

    Args:
        text: name of the place.
        label: name of the parameter.
        root: folder, links resolved.
        base: folder that the name is relative to, by default the root.
    """
    place = (base or root) / text
    if text.startswith("~") or not is_inside(place, root):
        raise InputError(f"given {text!r}, which lies outside of {root}; name a file in that folder", key=label)
    for link in links_below(place):
        if not is_inside(link, root):
            raise InputError(f"given {text!r}, in which {link} leads outside of {root}; remove the link", key=label)


def is_inside(place: Path, root: Path) -> bool:
    """Return True for a place in the root, all its links resolved."""
    return Path(os.path.realpath(place)).is_relative_to(root)


def links_below(folder: Path, depth: int = MAX_DEPTH) -> Iterator[Path]:
    """Yield the links in a folder and its subfolders, hidden ones aside."""
    try:
        with os.scandir(folder) as scan:
            entries = [entry for entry in scan if not entry.name.startswith(".")]
    except OSError:
        # No folder, or none that this user can read.
        return
    for entry in entries:
        if entry.is_symlink():
            yield Path(entry.path)
        elif depth > 1 and entry.is_dir():
            yield from links_below(Path(entry.path), depth - 1)
