"""Checks of plain user values: each returns the value in its final type or raises InputError with its key."""

from collections.abc import Sequence
from math import inf, isfinite

from plant.errors import InputError, UnknownNameError


def number(value: object, key: str, low: float = -inf, high: float = inf, *, above: bool = False) -> float:
    """Return a finite number in [low, high], or in (low, high] with above; a bool is not a number."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not isfinite(value):
        raise InputError(f"given {value!r}; give a finite number", key=key)
    if value < low or value > high or (above and value == low):
        raise InputError(f"given {value!r}; {_allowed(low, high, above)}", key=key)
    return float(value)


def numbers(value: object, key: str, count: int, low: float = -inf, *, above: bool = False) -> tuple[float, ...]:
    """Return `count` finite numbers, each at least low (greater than low with above), as a tuple."""
    if isinstance(value, str) or not isinstance(value, Sequence) or len(value) != count:
        raise InputError(f"given {value!r}; give {count} numbers", key=key)
    return tuple(number(item, key, low, above=above) for item in value)


def switch(value: object, key: str) -> bool:
    """Return a bool; anything else, 0 and 1 included, is an error."""
    if not isinstance(value, bool):
        raise InputError(f"given {value!r}; give true or false", key=key)
    return value


def name(value: object, key: str, kind: str, valid: Sequence[str]) -> str:
    """Return a name that is among the valid ones; UnknownNameError otherwise."""
    if value not in valid:
        raise UnknownNameError(kind, str(value), valid, key=key)
    return str(value)


def _allowed(low: float, high: float, above: bool) -> str:
    least = f"greater than {low:g}" if above else f"at least {low:g}"
    return f"give a number {least}" + ("" if high == inf else f" and at most {high:g}")
