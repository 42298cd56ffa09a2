"""The parts of a chart as plain data: panels with two axes and marks on them. Nothing here knows how they are drawn."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np

from tuner.report.charts.look import Look
from tuner.text.numbers import significant
from tuner.text.units import bracketed

Array = np.ndarray
FAR = 1e9
"""End of a region that has none."""
Show = Mapping[str, str | Sequence[str]]
"""When a mark is seen in the page: choice ("point", "scenario", "channel", "layer", "part") -> the value, or list of values."""


class Axis(NamedTuple):
    """An axis: its title with unit, the ends shown (None: as the marks need), named ticks, and a step between ticks."""

    title: str = ""
    low: float | None = None
    high: float | None = None
    log: bool = False
    ticks: tuple[tuple[float, str], ...] = ()
    step: float | None = None
    bare: bool = False
    """On paper its ticks have no numbers, and it has no title: another panel shows them."""

    @property
    def ends(self) -> tuple[float, float] | None:
        """Both ends, None where they are left to the marks."""
        return None if self.low is None or self.high is None else (self.low, self.high)


@dataclass(frozen=True, kw_only=True, eq=False)
class Mark:
    """Properties of all marks: a name for legends and pointers ("": none), a look, and when the page shows it."""

    look: Look
    name: str = ""
    show: Show = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True, eq=False)
class Points(Mark):
    """Points (n,) with intervals, given by their ends.

    labels: names of the points, by which the page picks and filters them. hover: lines under the pointer. texts: next to the
    marks, at `place` ("top right", "bottom left"). edge: a point beyond the ends of an axis stands at its
    edge as an arrow head instead of being left out.
    """

    x: Array
    y: Array
    x_ends: tuple[Array, Array] | None = None
    y_ends: tuple[Array, Array] | None = None
    labels: Sequence[str] = ()
    hover: Sequence[str] = ()
    texts: Sequence[str] = ()
    place: str = "top right"
    edge: bool = False


@dataclass(frozen=True, kw_only=True, eq=False)
class Line(Mark):
    """A line through points (n,), broken where they are NaN. steps: level up to the next point.

    tips: two further series told under the pointer. marked: points that have the symbol of its look. coarse: 16 bits a number
    are enough for the page.
    """

    x: Array
    y: Array
    steps: bool = False
    marked: slice | None = None
    tips: tuple[Array, Array] | None = None
    tip: str = ""
    coarse: bool = False


@dataclass(frozen=True, kw_only=True, eq=False)
class Band(Mark):
    """The area between two series (n,); hatched where the symbol of its look is "/"."""

    x: Array
    low: Array
    high: Array
    coarse: bool = False


@dataclass(frozen=True, kw_only=True, eq=False)
class Bars(Mark):
    """Bars (n,) from zero. across: they lie, at heights y. ends: intervals. stacked: on top of the bars before them."""

    x: Array
    y: Array
    ends: tuple[Array, Array] | None = None
    across: bool = False
    width: float = 0.8
    labels: Sequence[str] = ()
    stacked: bool = False


@dataclass(frozen=True, kw_only=True, eq=False)
class Rule(Mark):
    """A straight line across the whole panel: where `axis` has `value`."""

    axis: Literal["x", "y"]
    value: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Disc(Mark):
    """A circle; filled, hatched or bare."""

    x: float
    y: float
    radius: float
    fill: Literal["", "filled", "hatched"] = ""


@dataclass(frozen=True, kw_only=True, eq=False)
class Region(Mark):
    """The part of a grid of x (k,) and y (l,) where values (l, k) lie between two ends, outlined there; NaN: nowhere."""

    x: Array
    y: Array
    values: Array
    low: float = -np.inf
    high: float = np.inf

    @property
    def ends(self) -> tuple[float, float]:
        """Both ends as finite numbers, which renderers need."""
        return max(self.low, -FAR), min(self.high, FAR)


@dataclass(frozen=True, kw_only=True, eq=False)
class Words(Mark):
    """A text at a place; right: its x is a share of the panel's width; inside: its y is one of the height as well."""

    x: float
    y: float
    text: str
    place: Literal["", "right", "inside"] = ""


@dataclass(frozen=True, eq=False)
class Panel:
    """Marks over two axes. key: id in the page; form: how large it is there; aid: how to read it, in one line.

    square: a unit is as long on both axes. hides: the page leaves it out where none of its marks is seen. rows: its y axis is a
    list of rows. legend: the marks are named above it, on paper under its title.
    """

    key: str
    title: str
    x: Axis
    y: Axis
    marks: Sequence[Mark]
    form: str = "axis"
    aid: str = ""
    tip: str = ""
    square: bool = False
    hides: bool = False
    rows: bool = False
    legend: bool = False
    stacked: bool = False
    across: bool = False


def row_axis(names: Sequence[str]) -> Axis:
    """Return the axis of so many named rows, the first on top: row i stands at -i."""
    return Axis("", 0.4 - len(names), 0.6, ticks=tuple((-float(i), name) for i, name in enumerate(names)))


def segments(low: Array, high: Array, height: Array, look: Look) -> Line:
    """Return intervals (n,) at heights (n,) as one line with gaps."""
    x = np.stack([low, high, np.full(len(low), np.nan)], axis=1).ravel()
    return Line(look=look, x=x, y=np.repeat(height, 3))


def value_axis(label: str, unit: str, span: "AxisRange") -> Axis:
    """Return an axis of a quantity over a span, with ticks in full where it is logarithmic."""
    return span.axis(bracketed(label, unit))


class AxisRange(NamedTuple):
    """Ends of an axis in the unit of its quantity."""

    low: float
    high: float
    log: bool

    def axis(self, title: str) -> Axis:
        """Return an axis from end to end, with ticks in full where it is logarithmic."""
        ticks = tuple((value, significant(value)) for value in self.ticks()) if self.log else ()
        return Axis(title, self.low, self.high, self.log, ticks)

    def ticks(self) -> list[float]:
        """Return round numbers inside a logarithmic span: the fewer in a decade, the more decades there are."""
        decades = np.log10(self.high / self.low)
        digits = (1.0, 2.0, 5.0) if decades < 1.7 else (1.0, 3.0) if decades < 3.5 else (1.0,)
        powers = range(int(np.floor(np.log10(self.low))), int(np.ceil(np.log10(self.high))) + 1)
        values = [digit * 10.0**power for power in powers for digit in digits]
        return [value for value in values if self.low <= value <= self.high]


def span_of(parts: Sequence[Array], log_factor: float, padding: float = 0.06) -> AxisRange:
    """Return a span that holds all finite values of some arrays, with a little air around them.

    log_factor: logarithmic where they are positive and span more than this factor, so that they do not huddle in a corner.
    """
    values = np.concatenate([np.asarray(part, dtype=float).ravel() for part in parts] or [np.zeros(0)])
    values = values[np.isfinite(values)]
    if len(values) == 0:
        return AxisRange(0.0, 1.0, False)
    low, high = float(values.min(axis=0)), float(values.max(axis=0))
    if low > 0.0 and high > log_factor * low:
        stretch = (high / low) ** padding
        return AxisRange(low / stretch, high * stretch, True)
    margin = padding * (high - low) or 0.1 * abs(high) or 1.0
    return AxisRange(low - margin, high + margin, False)
