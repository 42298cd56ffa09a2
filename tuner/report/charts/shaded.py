"""Limits on margins in Bode and Nyquist charts: what they forbid is shaded, for reports and the studio alike."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from objectives.margins.quantities import QUANTITIES
from plant.quadrotor.gains import GROUPS
from tuner.analysis.margins.limits import LIMITS
from tuner.report.charts.chart import Array, Axis, Band, Disc, Line, Mark, Show
from tuner.report.charts.look import Look
from tuner.text.sentences import bound_text

FORBIDDEN = Look("bad", width=0.8, opacity=0.12)
"""Look of the part that a limit forbids."""
EDGE = Look("bad", dash=(2, 2), width=2.5)
"""Look of the part of the unit circle, and of the real axis, that a curve must not cross."""
SHADED_QUANTITIES = ("phase_margin", "gain_margin", "ms")
"""Quantities that charts shade."""
USUAL = {"gain_up": "gain_margin"}
"""Quantity of the usual limits -> the quantity of a study that it is."""
MAX_GAIN = 200.0
"""Largest gain margin that is shaded [dB]."""


class ShadedLimit(NamedTuple):
    """A limit that charts shade.

    Attributes:
        quantity: Name of the margin, one of `SHADED_QUANTITIES`.
        limit: Value in the unit of a study: deg, dB, 1.
        channels: Loops that it is on, () for every loop.
    """

    quantity: str
    limit: float
    channels: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The limit in words: "phase margin, min 35 deg"."""
        quantity = QUANTITIES[self.quantity]
        unit = "" if quantity.limit_unit == "1" else f" {quantity.limit_unit}"
        return f"{quantity.label}, {bound_text(self.limit, quantity.sense)}{unit}"

    @property
    def show(self) -> Show:
        """When the page shows it."""
        return {"channel": list(self.channels)} if self.channels else {}


def shaded_limits(limits: Iterable[tuple[str, float]], channels: Sequence[str]) -> list[ShadedLimit]:
    """Return the limits that charts shade: the usual ones if none is on what they show.

    Args:
        limits: Label of each limit of a study, and its value in the unit of the study.
        channels: Names of all loops.
    """
    entries = [_limit(label, value, channels) for label, value in limits]
    shown = [entry for entry in entries if entry.quantity in SHADED_QUANTITIES]
    usual = [ShadedLimit(USUAL.get(entry.quantity, entry.quantity), entry.limit) for entry in LIMITS]
    return shown or [entry for entry in usual if entry.quantity in SHADED_QUANTITIES]


def _limit(label: str, value: float, channels: Sequence[str]) -> ShadedLimit:
    """Return a limit by its label, as "phase_margin(attitude, spread)"."""
    quantity, _, words = label.removesuffix(")").partition("(")
    axis = words.partition(",")[0]
    return ShadedLimit(quantity, value, (axis,) if axis in channels else GROUPS.get(axis, ()))


def limit_marks(
    limits: Sequence[ShadedLimit], frequency: Axis, phase: Axis
) -> tuple[list[Mark], list[Mark], list[Mark]]:
    """Return marks of limits: in gain, phase and plane.

    Args:
        limits: Limits to shade.
        frequency: Axis that they reach across.
        phase: Axis of the phase.
    """
    over, under, plane = list[Mark](), list[Mark](), list[Mark]()
    across = np.array(frequency.ends or (1e-3, 1e4))
    for entry in limits:
        if entry.quantity == "gain_margin":
            size = min(abs(entry.limit), MAX_GAIN)
            over.append(_band(entry, across, 0.0, size))
            ratio = 10.0 ** (size / 20.0)
            plane.append(_edge(entry, np.array([-ratio, -1.0 / ratio]), np.zeros(2)))
        elif entry.quantity == "phase_margin":
            under += [_band(entry, across, turn, entry.limit) for turn in odd_half_turns(phase)]
            angle = np.radians(180.0 + entry.limit * np.linspace(-1.0, 1.0, 41))
            plane.append(_edge(entry, np.cos(angle), np.sin(angle)))
        elif entry.limit > 0.0:
            size = 1.0 / entry.limit
            plane.append(
                Disc(look=FORBIDDEN, name=entry.name, x=-1.0, y=0.0, radius=size, fill="filled", show=entry.show)
            )
    return over, under, plane


def odd_half_turns(phase: Axis) -> list[float]:
    """Return phases of -1 on an axis [deg]: -180 if it has no ends."""
    low, high = phase.ends or (-180.0, -180.0)
    turns = np.arange(np.ceil((low + 180.0) / 360.0), np.floor((high + 180.0) / 360.0) + 1.0)
    return (360.0 * turns - 180.0).tolist()


def _band(entry: ShadedLimit, across: Array, middle: float, size: float) -> Band:
    low, high = (np.full(len(across), middle + end) for end in (-size, size))
    return Band(look=FORBIDDEN, name=entry.name, x=across, low=low, high=high, show=entry.show)


def _edge(entry: ShadedLimit, x: Array, y: Array) -> Line:
    return Line(look=EDGE, name=entry.name, x=x, y=y, tip="not across this line", show=entry.show)
