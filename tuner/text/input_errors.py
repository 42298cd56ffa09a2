"""Errors of what a file holds: with the path to an inner table, and for numbers out of all proportion.

`[airframe]` stands in front of `name`, the file in front of both. Beyond the sizes below a digit or a unit slipped, and
arithmetic overflows instead of telling.
"""

import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from pydantic_core import ErrorDetails

from plant.errors import InputError
from plant.texts import values_in

E = TypeVar("E")
T = TypeVar("T")

SMALLEST, LARGEST = 1e-9, 1e6
"""Size of any number of a study that is not 0, in the unit of its key."""
USABLE_SIZES = (1e-30, 1e30)
"""Sizes in studies of plants and trials, whose units are free: products of several such numbers are floats too."""
# What there is of a quantity, and its unit; 60 m/s is the wind of the strongest hurricanes but one class.
RANGES = {
    "limits.position": (0.001, 1000.0, "m"),
    "scenario.air.intensity": (0.0, 60.0, "m/s at 20 ft"),
    "scenario.air.vehicle_speed": (-100.0, 100.0, "m/s"),
    "scenario.air.minimum_airspeed": (0.0, 100.0, "m/s"),
    "scenario.air.wind_direction_deg": (-360.0, 360.0, "deg"),
    "scenario.air.span": (0.0, 10.0, "m"),
    "scenario.air.gust.amplitude": (-60.0, 60.0, "m/s"),
    "scenario.sensors.position": (0.0, 100.0, "m"),
    "scenario.sensors.velocity": (0.0, 100.0, "m/s"),
    "scenario.sensors.attitude": (0.0, 1.0, "rad"),
    "scenario.sensors.rate": (0.0, 100.0, "rad/s"),
    "scenario.bands.settling": (0.0, 1.0, "of the step"),
    "scenario.bands.position": (0.0, 1000.0, "m"),
    "scenario.bands.attitude": (0.0, 3.2, "rad"),
}
# No quantities: counts have limits of their own, a seed has none.
FREE = ("seed", "search.population", "search.generations")


class Fault(NamedTuple):
    """A problem that pydantic found: its type, the steps to the value, the value, pydantic's message and what that names."""

    kind: str
    place: tuple[int | str, ...]
    given: Any
    message: str
    context: dict[str, Any]

    @classmethod
    def of(cls, error: ErrorDetails) -> "Fault":
        """Return a problem as pydantic tells it."""
        return cls(error["type"], error["loc"], error["input"], error["msg"], error.get("ctx", {}))


@contextmanager
def located(path: Path | None, key: str) -> Iterator[None]:
    """Prefix an inner error's key with a table and name the file; None leaves the file to an outer one."""
    try:
        yield
    except InputError as error:
        if error.file is not None:
            raise
        inner = error.key or ""
        raise moved(error, path, f"{key}.{inner}" if key and inner else key or inner) from None


def listed(name: str, path: Path | None, entries: Iterable[E], make: Callable[[E], T]) -> Iterator[T]:
    """Yield what a list of tables becomes; errors name the file and the place in the list."""
    for i, entry in enumerate(entries):
        with located(path, f"{name}[{i}]"):
            yield make(entry)


def moved(error: InputError, path: Path | None, key: str) -> InputError:
    """Return the error as one of this file and key."""
    copy = type(error).__new__(type(error))
    InputError.__init__(copy, error.message, file=path, key=key or None)
    return copy


def dotted(path: Iterable[str | int]) -> str:
    """Return a path as a key: ("scenario", 0, "air") is "scenario[0].air"."""
    key = ""
    for part in path:
        key = f"{key}[{part}]" if isinstance(part, int) else joined(key, part)
    return key


def joined(key: str, name: str) -> str:
    """Return the key of a name in a table; an empty name has to be seen."""
    name = name or '""'
    return f"{key}.{name}" if key else name


def check_magnitudes(table: Any, path: Path) -> None:
    """Refuse nested numbers (of tables and lists) beyond all proportion; InputError names the key."""
    for key, value in numbers_in(table):
        if key not in FREE:
            check_magnitude(value, path, key)
            _check_range(value, path, key)


def check_sizes(table: Any, path: Path) -> None:
    """Refuse nested numbers with which no arithmetic of floats is possible; InputError names the key."""
    for key, value in numbers_in(table):
        if key not in FREE:
            check_magnitude(value, path, key, USABLE_SIZES)


def _check_range(value: float, path: Path, key: str) -> None:
    low, high, unit = RANGES.get(re.sub(r"\[\d+\]", "", key), (value, value, ""))
    if not low <= value <= high:
        message = f"given {value:g}; allowed: {low:g} to {high:g} {unit}: correct the value or its unit"
        raise InputError(message, file=path, key=key)


def check_magnitude(
    value: float, path: Path | None, key: str, sizes: tuple[float, float] = (SMALLEST, LARGEST)
) -> None:
    """Refuse a number that is out of all proportion; others refuse those that are not finite."""
    smallest, largest = sizes
    if isfinite(value) and value != 0.0 and not smallest <= abs(value) <= largest:
        message = (
            f"given {value:g}; allowed: 0, or a size from {smallest:g} to {largest:g}: correct the value or its unit"
        )
        raise InputError(message, file=path, key=key)


def numbers_in(table: Any) -> Iterator[tuple[str, float]]:
    """Yield dotted key and value of all numbers in nested tables."""
    for key, value in values_in(table):
        if isinstance(value, int | float) and not isinstance(value, bool):
            yield key, value
