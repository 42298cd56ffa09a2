"""Numbers of gains.json: {value, unit}, with UCUM case-sensitive codes for the spellings that the rest of the tool uses.

The Unified Code for Units of Measure, version 2.1, 2017 (ucum.org). It has no fractional exponents: a unit with a root is
written as an annotation in braces, which UCUM takes for a dimensionless number that a person can read.
"""

from collections.abc import Iterator
from math import inf
from typing import Any, NamedTuple

from plant.errors import InputError

UCUM = {
    "1": "1", "%": "%", "dB": "dB", "deg": "deg", "byte": "By",
    "kg": "kg", "kg m2": "kg.m2", "N": "N", "N m": "N.m", "N m s": "N.m.s", "N s/m": "N.s/m", "N s2": "N.s2",
    "N s2/m2": "N.s2/m2", "V": "V", "Ohm": "Ohm", "A s": "A.s", "W": "W",
    "s": "s", "s^2": "s2", "us": "us", "Hz": "Hz", "1/s": "s-1", "s^-1": "s-1", "s^-2": "s-2", "s^-3": "s-3",
    "m": "m", "m s": "m.s", "m s^2": "m.s2", "m^2 s": "m2.s", "m/s": "m/s", "m/s2": "m/s2", "m/s^2": "m/s2", "m s^-2": "m/s2",
    "m/s^3": "m/s3", "m s^-3": "m/s3",
    "rad": "rad", "rad s": "rad.s", "rad s^2": "rad.s2", "rad^2 s": "rad2.s", "rad/s": "rad/s", "rad/s^2": "rad/s2",
    "rad s^-2": "rad/s2", "rad/s^3": "rad/s3", "rad s^-3": "rad/s3",
    "s/rad": "s/rad", "s^2/rad": "s2/rad", "1/rad": "rad-1", "s/m": "s/m", "s^2/m": "s2/m", "1/m": "m-1",
    "m^(1/2) s^(-3/2)": "{m^0.5.s^-1.5}", "rad^(1/2) s^(-3/2)": "{rad^0.5.s^-1.5}",
    "m^(-1/2) s^(1/2)": "{m^-0.5.s^0.5}", "rad^(-1/2) s^(1/2)": "{rad^-0.5.s^0.5}",
}  # fmt: skip
"""Our spelling -> UCUM code."""


def ucum(unit: str) -> str:
    """Return the UCUM code of a unit in our spelling; raises InputError for one that the table lacks."""
    if unit not in UCUM:
        raise InputError(f"the unit '{unit}' has no UCUM code yet; add it to tuner/gains/quantities.py")
    return UCUM[unit]


def code_or_note(unit: str) -> str:
    """Return the UCUM code of a unit of the user's; one that the table lacks as an annotation, which UCUM takes for a number."""
    return UCUM.get(unit, "{" + unit.replace("{", "(").replace("}", ")") + "}")


def quantity(value: float, unit: str) -> dict[str, float | str]:
    """Return {value, unit} of a number whose unit is in our spelling."""
    return {"value": value, "unit": ucum(unit)}


class GainEntry(NamedTuple):
    """A gain in the file; low, high: the range that a search had for it, in the same unit."""

    value: float
    unit: str
    low: float = -inf
    high: float = inf


def quantities(block: Any, key: str = "") -> Iterator[tuple[str, float]]:
    """Yield dotted key and value of every quantity in a block."""
    if isinstance(block, dict) and "unit" in block:
        yield key, GainEntry(**block).value
    elif isinstance(block, dict):
        for name, inner in block.items():
            yield from quantities(inner, f"{key}.{name}" if key else name)
    elif isinstance(block, list):
        for i, inner in enumerate(block):
            yield from quantities(inner, f"{key}[{i}]")


def plain(block: Any) -> Any:
    """Return a block with every quantity as its number."""
    if isinstance(block, dict):
        return float(GainEntry(**block).value) if "unit" in block else {key: plain(part) for key, part in block.items()}
    return [plain(part) for part in block] if isinstance(block, list) else block
