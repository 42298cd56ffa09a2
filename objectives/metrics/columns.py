"""Where each number of a NamedTuple stands when the tuple is laid out as a row of an array.

The order is depth first through the annotations, the same in which every backend stores the tuple.
"""

from collections.abc import Iterator
from typing import Any, TypeVar, get_type_hints

from numpy.typing import NDArray

from objectives.meters import Meters

T = TypeVar("T", bound=tuple)


def paths(shape: type) -> tuple[str, ...]:
    """Return the dotted path of every scalar of a NamedTuple class, depth first: ("x.itae", "x.iae", ...)."""
    found: list[str] = []
    for name, kind in get_type_hints(shape).items():
        found += [name] if kind is float else [f"{name}.{inner}" for inner in paths(kind)]
    return tuple(found)


COLUMNS: dict[str, int] = {path: column for column, path in enumerate(paths(Meters))}
"""Column of every meter in an array of shape (..., len(COLUMNS)), by dotted path."""


def unpack(shape: type[T], array: NDArray[Any]) -> T:
    """Return a NamedTuple whose scalars are views of shape (...) on the columns of an array (..., columns)."""
    assert array.shape[-1] == len(paths(shape)), f"{array.shape[-1]} columns for {len(paths(shape))} fields"
    return _unpack(shape, (array[..., column] for column in range(array.shape[-1])))


def _unpack(shape: type[T], columns: Iterator[NDArray[Any]]) -> T:
    parts = [next(columns) if kind is float else _unpack(kind, columns) for kind in get_type_hints(shape).values()]
    return shape(*parts)
