"""Units in which SI values are drawn, printed or limited: decibels, degrees, milliseconds."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Scale:
    """A display unit, with its conversion from and to files' SI unit.

    unit, si_unit: names, "1" for factors and ratios. shown(value), si(value): for numbers and for arrays.
    """

    unit: str
    si_unit: str
    shown: Callable[[Any], Any]
    si: Callable[[Any], Any]


def decibel(factor: Any) -> Any:
    """Return 20 log10 of factors."""
    return 20.0 * np.log10(factor)


def _factor(level: Any) -> Any:
    return 10.0 ** (level / 20.0)


DECIBEL = Scale("dB", "1", decibel, _factor)
DEGREES = Scale("deg", "rad", np.degrees, np.radians)
MILLISECONDS = Scale("ms", "s", lambda time: 1e3 * time, lambda time: 1e-3 * time)

SCALES = {scale.unit: scale for scale in (DECIBEL, DEGREES, MILLISECONDS)}
"""Every scale by the name of its unit."""


def units_of(unit: str, scale: Scale | None) -> dict[str, str]:
    """Return the unit entries of a document's row for a number.

    The number's limit is given in `unit`.
    "unit" is that of files; "shown_unit", where it is another one, that in which the number is drawn and printed.
    """
    return {"unit": unit} if scale is None else {"unit": scale.si_unit, "shown_unit": scale.unit}


def in_file(value: Any, scale: Scale | None) -> Any:
    """Return a number (None: infinite) in the unit of files."""
    return value if scale is None or value is None else scale.si(value)
