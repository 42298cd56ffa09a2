"""Units as a reader sees them: angles in degrees, exponents raised.

Inside, units are written as in metrics and laws: factors separated by spaces, "^2" or "^(-3/2)" for powers, "/" for a
quotient, "1" for none.
"""

import re
from html import escape
from math import pi
from typing import Any, NamedTuple

from objectives.scales import SCALES, Scale
from tuner.text.markup import Markup

_RADIAN = re.compile(r"(?<![/\w])rad(?:\^(\d+))?(?![\w^])")
_POWER = re.compile(r"\^(?:\(([^)]*)\)|(-?\d+))")
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


# Keys of a row of a document whose numbers have the row's unit.
SHOWN = ("limit", "relaxed", "value", "default", "tuned", "asked", "held")


class Shown(NamedTuple):
    """Presentation of a quantity: its unit, "" for none, and the factor that turns stored into shown numbers."""

    unit: str
    factor: float


def in_degrees(unit: str) -> Shown:
    """Return the unit with angles in degrees; only whole powers of rad in the numerator are converted."""
    found = _RADIAN.search(unit)
    if found is None:
        return Shown("" if unit == "1" else unit, 1.0)
    power = int(found[1] or 1)
    degrees = "°" if power == 1 else f"°^{power}"
    return Shown(unit[: found.start()] + degrees + unit[found.end() :], (180.0 / pi) ** power)


def in_shown_units(row: dict[str, Any]) -> dict[str, Any]:
    """Return a row of a document with its numbers in its "shown_unit", as "unit"; a row without one as it is.

    Numbers are those under the keys of `SHOWN`, alone or as the value of an estimate; a difference is that of shown numbers.
    """
    if "shown_unit" not in row:
        return row
    scale = SCALES[row["shown_unit"]]
    shown = {**row, "unit": scale.unit} | {key: _scaled(row[key], scale) for key in SHOWN if key in row}
    if "states" in row:
        shown["states"] = [
            entry | {key: _scaled(entry[key], scale) for key in SHOWN if key in entry} for entry in row["states"]
        ]
    if isinstance(row.get("difference"), dict) and row["difference"]["value"] is not None:
        apart = shown["tuned"]["value"] - shown["default"]["value"]
        shown["difference"] = {**row["difference"], "value": apart}
    return shown


def _scaled(entry: Any, scale: Scale) -> Any:
    if isinstance(entry, dict):
        return {key: _scaled(part, scale) for key, part in entry.items()}
    return None if entry is None else float(scale.shown(entry))


def after_number(unit: str) -> str:
    """Return a unit as it follows a number in a sentence, " m"; nothing for "1"."""
    return "" if unit == "1" else f" {unit}"


def plain(unit: str) -> str:
    """Return a unit as plain text, whole exponents raised: "°² s", "s⁻²"."""
    return _POWER.sub(lambda m: m[0] if m[2] is None else m[2].translate(_RAISED), unit)


def marked_up(unit: str) -> Markup:
    """Return a unit as markup, all exponents raised."""
    return Markup(_POWER.sub(lambda m: f"<sup>{(m[1] or m[2]).replace('-', '−')}</sup>", escape(unit)))


def bracketed(label: str, unit: str) -> str:
    """Return "label [unit]", or the label alone where there is no unit, as plain text."""
    return f"{label} [{plain(unit)}]" if unit else label
