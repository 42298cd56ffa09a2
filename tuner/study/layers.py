"""The files a contest is made of: `base` chains, what is merged over what, and which file and table a key came from."""

import os
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path

from plant.errors import InputError
from plant.texts import PlainTable, PlainValue
from tuner.study.files import base_file
from tuner.study.reading import key_parts, parse_toml
from tuner.study.renamed import with_new_names
from tuner.text.toml_text import with_paths

REPLACED = ("airframe",)
"""Tables that are replaced and not merged: a name and a file, or a permission for another vehicle, do not go together."""


@dataclass(frozen=True)
class Layer:
    """The content of one file.

    Paths in it are relative to the folder of the first file of the chain.
    """

    path: Path
    table: PlainTable


def read_layers(path: Path) -> tuple[Layer, ...]:
    """Return a file and its chain of `base` files, nearest first.

    Raises InputError where one is missing or in a circle.
    """
    layers: list[Layer] = []
    file = path
    while True:
        table = with_new_names(parse_toml(file), file)
        layers.append(Layer(file, _anchored(table, file.parent, path.parent)))
        name = table.get("base")
        if name is None:
            return tuple(layers)
        file = _base(file, name, [layer.path for layer in layers])


def _base(path: Path, name: object, seen: list[Path]) -> Path:
    if not isinstance(name, str):
        raise InputError(f'given {name!r}; write base = "other.toml"', file=path, key="base")
    base = base_file(path.parent, name)
    if not base.is_file():
        raise InputError(f"there is no file {base}; the path is relative to this file", file=path, key="base")
    if any(base.samefile(other) for other in seen):
        chain = " -> ".join(str(other) for other in [*seen, base])
        raise InputError(f"the files are based on each other in a circle: {chain}", file=path, key="base")
    return base


def merged_layers(layers: tuple[Layer, ...]) -> PlainTable:
    """Return the content of all layers, the nearest on top."""
    content: PlainTable = {}
    for layer in reversed(layers):
        content = laid_over(content, layer.table, REPLACED)
    content.pop("base", None)
    return content


def laid_over(under: Mapping[str, PlainValue], over: Mapping[str, PlainValue], replaced: tuple[str, ...]) -> PlainTable:
    """Return `under` with `over` merged over it; the tables named in `replaced` are replaced."""
    return merged({key: value for key, value in under.items() if key not in replaced or key not in over}, over)


def merged(under: Mapping[str, PlainValue], over: Mapping[str, PlainValue]) -> PlainTable:
    """Return `under` with `over` laid on top: tables key by key, everything else, lists too, replaced."""
    result = deepcopy(dict(under))
    for key, value in over.items():
        below = result.get(key)
        if isinstance(below, dict) and isinstance(value, dict):
            result[key] = merged(below, value)
        else:
            result[key] = deepcopy(value)
    return result


def _anchored(table: PlainTable, folder: Path, home: Path) -> PlainTable:
    if folder == home:
        return table
    return with_paths(table, lambda name: os.path.relpath(folder / name, home))


def depth(table: object, key: str) -> int:
    """Return the number of leading key parts that a table holds."""
    level, count = table, 0
    for part in key_parts(key):
        if isinstance(level, dict) and part in level:
            level = level[part]
        elif isinstance(level, list) and part.isdecimal() and int(part) < len(level):
            level = level[int(part)]
        else:
            break
        count += 1
    return count
