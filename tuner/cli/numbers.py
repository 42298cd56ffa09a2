"""Numbers for a terminal: the rules of `tuner.text.numbers`, in letters that can be copied into a file."""

from collections.abc import Mapping
from typing import Any

from tuner.text import numbers

PLAIN = str.maketrans({"−": "-", "\u202f": ","})


def digits(value: float, width: float) -> str:
    """Return a number with as many digits as the width of its interval, or a companion of that size, gives sense to."""
    return numbers.beside(value, width).translate(PLAIN)


def estimate(entry: Mapping[str, Any], signed: bool = False) -> str:
    """Return the value over its interval, or alone where it has none; signed: with a plus on positive values."""
    if entry["value"] is None:
        return "unbounded"
    if entry["low"] is None or entry["high"] is None:
        return f"{entry['value']:{'+' if signed and entry['value'] > 0.0 else ''}.4g}"
    value, interval = numbers.estimate(entry["value"], entry["low"], entry["high"])
    sign = "+" if signed and entry["value"] > 0.0 else ""
    return f"{sign}{value}\n{interval}".translate(PLAIN)


def difference(entry: Mapping[str, Any]) -> str:
    """Return a difference over its interval, with its sign."""
    return estimate(entry, signed=True)
