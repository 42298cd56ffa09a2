"""Columns of meters in rows of flights: leaf order of the record."""

from typing import Any

from numpy.typing import NDArray

from objectives.meters import Meters
from plant.records import pack, paths

COLUMNS: dict[str, int] = {path: column for column, path in enumerate(paths(Meters))}
"""Column of every meter in an array of shape (..., len(COLUMNS)), by dotted path."""


def unpack(shape: Any, array: NDArray[Any]) -> Any:
    """Return a record of views (...) on the columns of an array (..., columns)."""
    assert array.shape[-1] == len(paths(shape)), f"{array.shape[-1]} columns for {len(paths(shape))} fields"
    return pack(shape, (array[..., column] for column in range(array.shape[-1])))
