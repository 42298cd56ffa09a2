"""Units of gains and signals as exponents of SI base units, the form in which FMI 2.0 and SSP define a unit."""

import re
from collections.abc import Mapping
from fractions import Fraction

BASE = ("kg", "m", "s", "rad")
DERIVED = {"N": {"kg": 1, "m": 1, "s": -2}, "1": {}}
FACTOR = re.compile(r"(/?)\s*([A-Za-z]+|1)(?:\^(?:\((-?\d+(?:/\d+)?)\)|(-?\d+)))?\s*")


def exponents(unit: str) -> dict[str, Fraction]:
    """Return the exponents of kg, m, s, rad that are not 0 of a unit like "rad/s", "N m" or "rad^(1/2) s^(-3/2)"."""
    total: dict[str, Fraction] = {}
    place = 0
    while place < len(unit):
        found = FACTOR.match(unit, place)
        assert found is not None, f"'{unit}' is no unit of ours"
        slash, symbol, fraction, whole = found.groups()
        power = Fraction(fraction or whole or 1) * (-1 if slash else 1)
        parts: Mapping[str, int] = DERIVED.get(symbol) if symbol in DERIVED else {symbol: 1}  # pyright: ignore
        for base, count in parts.items():
            assert base in BASE, f"'{unit}' has the unknown unit '{symbol}'"
            total[base] = total.get(base, Fraction(0)) + power * count
        place = found.end()
    return {base: power for base, power in total.items() if power}


def base_unit(unit: str) -> dict[str, int] | None:
    """Return the exponents as whole numbers; None where one is a fraction, which FMI 2.0 and SSP cannot say."""
    found = exponents(unit)
    if any(power.denominator != 1 for power in found.values()):
        return None
    return {base: int(found[base]) for base in BASE if base in found}
