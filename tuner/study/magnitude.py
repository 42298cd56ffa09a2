"""Numbers out of all proportion: beyond these sizes a digit or a unit slipped, and arithmetic overflows instead of telling."""

from collections.abc import Iterator
from math import isfinite
from pathlib import Path
from typing import Any

from plant.errors import InputError

SMALLEST, LARGEST = 1e-9, 1e6
"""Size of any number of a study that is not 0, in the unit of its key."""
# No quantities: counts have limits of their own, a seed has none.
FREE = ("seed", "search.population", "search.generations")


def check_magnitudes(table: Any, path: Path) -> None:
    """Refuse a number of nested tables and lists that is out of all proportion; InputError naming its key."""
    for key, value in _numbers(table, ""):
        if key not in FREE:
            check_magnitude(value, path, key)


def check_magnitude(value: float, path: Path | None, key: str) -> None:
    """Refuse a number that is out of all proportion; what is not finite is for others to tell."""
    if isfinite(value) and value != 0.0 and not SMALLEST <= abs(value) <= LARGEST:
        message = (
            f"given {value:g}; allowed: 0, or a size from {SMALLEST:g} to {LARGEST:g}: correct the value or its unit"
        )
        raise InputError(message, file=path, key=key)


def _numbers(value: Any, key: str) -> Iterator[tuple[str, float]]:
    if isinstance(value, dict):
        for name, inner in value.items():
            yield from _numbers(inner, f"{key}.{name}" if key else str(name))
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from _numbers(inner, f"{key}[{i}]")
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield key, value
