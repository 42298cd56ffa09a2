"""Units as a reader sees them: angles in degrees, exponents raised.

Inside, units are written as in metrics and laws: factors separated by spaces, "^2" or "^(-3/2)" for powers, "/" for a
quotient, "1" for none.
"""

import re
from html import escape
from math import pi
from typing import NamedTuple

from tuner.text.markup import Markup

_RADIAN = re.compile(r"(?<![/\w])rad(?:\^(\d+))?(?![\w^])")
_POWER = re.compile(r"\^(?:\(([^)]*)\)|(-?\d+))")
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


class Shown(NamedTuple):
    """Presentation of a quantity: its unit, "" for none, and the factor that turns stored into shown numbers."""

    unit: str
    factor: float


def in_degrees(unit: str) -> Shown:
    """Return the unit with angles in degrees; only whole powers of rad in the numerator are converted."""
    match = _RADIAN.search(unit)
    if match is None:
        return Shown("" if unit == "1" else unit, 1.0)
    power = int(match[1] or 1)
    degrees = "°" if power == 1 else f"°^{power}"
    return Shown(unit[: match.start()] + degrees + unit[match.end() :], (180.0 / pi) ** power)


def after_number(unit: str) -> str:
    """Return a unit as it follows a number, " m"; nothing for "1" or ""."""
    return "" if unit in ("", "1") else f" {unit}"


def plain(unit: str) -> str:
    """Return a unit as plain text, whole exponents raised: "°² s", "s⁻²"."""
    return _POWER.sub(lambda m: m[0] if m[2] is None else m[2].translate(_RAISED), unit)


def marked_up(unit: str) -> Markup:
    """Return a unit as markup, all exponents raised."""
    return Markup(_POWER.sub(lambda m: f"<sup>{(m[1] or m[2]).replace('-', '−')}</sup>", escape(unit)))


def bracketed(label: str, unit: str) -> str:
    """Return "label [unit]" as plain text, or the label without unit."""
    return f"{label} [{plain(unit)}]" if unit else label
