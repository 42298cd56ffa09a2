"""Nested NamedTuples of scalars as flat rows of numbers, and back.

A record is a NamedTuple whose fields are floats, plain or annotated with a unit, or other records. Its leaves, depth first, are
the rows of a workspace or the columns of an array; they are named once, by the annotations.
"""

import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from plant.primitives import select

Record = Any
RecordType = Any


def is_leaf(part: Any) -> bool:
    """Return True if a record's field is a number: float, or Annotated[float, "m/s"]."""
    return part is float or getattr(part, "__origin__", None) is float


def is_record(kind: Any) -> bool:
    """Return True for a NamedTuple class."""
    return isinstance(kind, type) and issubclass(kind, tuple) and hasattr(kind, "_fields")


def unit_of(part: Any) -> str:
    """Return the unit that a leaf is annotated with, "" for none."""
    return str(getattr(part, "__metadata__", ("",))[0])


def record_type(name: str, fields: dict[str, RecordType]) -> RecordType:
    """Return a NamedTuple class made at run time."""
    return NamedTuple(name, list(fields.items()))  # pyright: ignore[reportGeneralTypeIssues, reportArgumentType]


def parts(kind: RecordType) -> set[RecordType]:
    """Return a record type and all record types inside it."""
    inside = [parts(part) for part in kind.__annotations__.values() if not is_leaf(part)]
    return {kind}.union(*inside)


def source_of(kind: type) -> Path:
    """Return the file that a record class was written in; the empty path for one of a notebook's cell."""
    return Path(getattr(sys.modules[kind.__module__], "__file__", None) or "")


@cache
def paths(kind: RecordType) -> tuple[str, ...]:
    """Return the dotted path of every leaf of a record type, depth first."""
    return tuple(_paths(kind, ""))


def _paths(kind: RecordType, prefix: str) -> Iterator[str]:
    for name, part in kind.__annotations__.items():
        if is_leaf(part):
            yield prefix + name
        else:
            yield from _paths(part, f"{prefix}{name}.")


def size(kind: RecordType) -> int:
    """Return the number of leaves of a record type."""
    return len(paths(kind))


def index(kind: RecordType, path: str) -> int:
    """Return the row of the leaf at a dotted path."""
    return paths(kind).index(path)


def rows(kind: RecordType, path: str) -> slice:
    """Return the rows of the part at a dotted path."""
    inside = [i for i, leaf in enumerate(paths(kind)) if leaf == path or leaf.startswith(path + ".")]
    return slice(inside[0], inside[-1] + 1)


def pack(kind: RecordType, values: Iterable[Any]) -> Record:
    """Build a record from its leaves, depth first."""
    stream = iter(values)
    return _pack(kind, stream)


def _pack(kind: RecordType, stream: Iterator[Any]) -> Record:
    return kind(*[next(stream) if is_leaf(part) else _pack(part, stream) for part in kind.__annotations__.values()])


def zeros(kind: RecordType) -> Record:
    """Return the record whose leaves are all 0."""
    return pack(kind, [0.0] * size(kind))


def flatten(record: Record) -> list[Any]:
    """Return the leaves of a record, depth first."""
    leaves: list[Any] = []
    for part in record:
        leaves.extend(flatten(part) if isinstance(part, tuple) else [part])
    return leaves


def build_source(kind: RecordType, leaves: Sequence[str], classes: dict[str, RecordType]) -> str:
    """Return the expression of a record of leaf expressions; collects the classes it calls."""
    return _build_source(kind, iter(leaves), classes)


def _build_source(kind: RecordType, leaves: Iterator[str], classes: dict[str, RecordType]) -> str:
    name = kind.__name__
    while classes.setdefault(name, kind) is not kind:
        name += "_"
    parts = [
        next(leaves) if is_leaf(part) else _build_source(part, leaves, classes)
        for part in kind.__annotations__.values()
    ]
    return f"{name}({', '.join(parts)})"


def selector(kind: RecordType) -> Callable[..., Any]:
    """Return the model function (condition, a, b) -> record, a selection leaf by leaf."""
    names: dict[str, Any] = {"__name__": __name__, "select": select}
    body = build_source(kind, [f"select(condition, a.{path}, b.{path})" for path in paths(kind)], names)
    exec(f"def select_{kind.__name__}(condition, a, b):\n    return {body}", names)
    return names[f"select_{kind.__name__}"]


def axpy_of(kind: RecordType) -> Callable[..., Any]:
    """Return the model function (a, s, b) -> a + s b on records, leaf by leaf."""
    names: dict[str, Any] = {"__name__": __name__}
    body = build_source(kind, [f"a.{path} + s * b.{path}" for path in paths(kind)], names)
    exec(f"def axpy_{kind.__name__}(a, s, b):\n    return {body}", names)
    return names[f"axpy_{kind.__name__}"]
