"""Small drawings in rows of a table: intervals with marks, a zero line, a limit, a printed number, a place in a range, a scale.

The numbers stand next to them, so they are hidden from screen readers. Colours and strokes come from page.css.
"""

from collections.abc import Iterable
from math import floor, isfinite, log10
from typing import NamedTuple

from tuner.documents.parts import Estimate
from tuner.report.charts.look import DEFAULT, TUNED, Look, drawn_mark
from tuner.text.markup import Markup, element, join
from tuner.text.numbers import significant

WIDTH, NARROW, INSET, ROW = 220.0, 132.0, 12.0, 18.0
# Height of a row of drawings that stand close below each other.
CLOSE_ROW = 13.0
# Where positive values span more than this factor, a linear scale would press most of them into a corner.
LOG_FACTOR = 30.0
PADDING = 0.04
# Width of a letter of the scale [px].
LETTER = 6.0


class StripScale(NamedTuple):
    """Scale of a drawing from its left to its right end."""

    low: float
    high: float
    log: bool = False
    width: float = WIDTH

    def share(self, value: float) -> float:
        """Return the place of a value, 0 at the left end and 1 at the right; the ends where it is outside."""
        inside = min(max(value, self.low), self.high)
        if self.log:
            return log10(inside / self.low) / log10(self.high / self.low)
        return (inside - self.low) / (self.high - self.low)

    def place(self, value: float) -> float:
        """Return the place of a value [px]."""
        return INSET + (self.width - 2 * INSET) * self.share(value)


def scale(numbers: Iterable[float | None], zero: bool = True) -> StripScale:
    """Return a scale that holds all numbers that there are, and zero where asked; logarithmic where they cover decades."""
    finite = [number for number in numbers if number is not None and isfinite(number)]
    if finite and min(finite) > 0.0 and max(finite) > LOG_FACTOR * min(finite):
        return StripScale(0.8 * min(finite), 1.25 * max(finite), True)
    finite += [0.0] if zero or not finite else []
    low, high = min(finite), max(finite)
    if low == high:
        return StripScale(low, low + (abs(low) or 1.0))
    margin = PADDING * (high - low)
    # Zero itself is a fine end of a scale, anything else would stand on the edge.
    return StripScale(low - margin if low else low, high + margin if high else high)


def interval(shown: StripScale, estimate: Estimate, clear: bool) -> Markup:
    """Draw a difference with its interval over the zero line; clear: the interval leaves out zero, so it is filled."""
    name = "clear" if clear else "unclear"
    parts = [_upright(shown, 0.0, "zero", ROW), _whisker(shown, estimate, ROW / 2, name)]
    if estimate.value is not None:
        x = shown.place(estimate.value)
        parts.append(element("path", d=f"M{x:.1f} {ROW / 2 - 5:.1f}l5 5l-5 5l-5 -5z", class_=f"diamond {name}"))
    return _drawing(parts, shown.width, ROW)


def stacked(shown: StripScale, rows: list[tuple[Look, Estimate]], limit: float | None) -> Markup:
    """Draw an interval for each contender, one below the other, zero, and the limit."""
    height = CLOSE_ROW * len(rows) + 4.0
    parts = [_upright(shown, 0.0, "zero", height)] if shown.low <= 0.0 <= shown.high else []
    if limit is not None:
        parts.append(_upright(shown, limit, "limit", height))
    for i, (look, estimate) in enumerate(rows):
        y = 2.0 + CLOSE_ROW * (i + 0.5)
        parts.append(_whisker(shown, estimate, y, look.colour))
        if estimate.value is not None:
            parts.append(drawn_mark(look, shown.place(estimate.value), y, 12.0))
    return _drawing(parts, shown.width, height)


def pinned(shown: StripScale, central: Estimate, printed: float, look: Look, inside: bool) -> Markup:
    """Draw a central interval as a bar with its median (`central.value`), and a printed number as a pin."""
    y, parts = ROW / 2 + 3.0, []
    if central.low is not None and central.high is not None:
        left, right = shown.place(central.low), shown.place(central.high)
        bar = {"x": f"{left:.1f}", "y": f"{y - 4:.1f}", "width": f"{max(right - left, 1.5):.1f}", "height": 8, "rx": 2}
        parts.append(element("rect", **bar, class_=f"bar {look.colour}"))
    if central.value is not None:
        parts.append(
            _line(shown.place(central.value), y - 5, shown.place(central.value), y + 5, f"median {look.colour}")
        )
    x = shown.place(printed)
    parts.append(_line(x, y - 4, x, y + 5, "pin"))
    head = f"M{x:.1f} {y - 3:.1f}l-4.5 -8h9z"
    parts.append(element("path", d=head, class_=f"pin {'inside' if inside else 'outside'}"))
    return _drawing(parts, shown.width, ROW + 2.0)


def placed(shown: StripScale, default: float, value: float) -> Markup:
    """Draw where default and value lie in a range."""
    y = ROW / 2
    parts = [_line(INSET, y, shown.width - INSET, y, "track")]
    parts += [_line(x, y - 5, x, y + 5, "track") for x in (INSET, shown.width - INSET)]
    parts += [drawn_mark(DEFAULT, shown.place(default), y, 12.0), drawn_mark(TUNED, shown.place(value), y, 14.0)]
    return _drawing(parts, shown.width, ROW)


def ruler(shown: StripScale) -> Markup:
    """Draw the scale: a line, ticks at round numbers, and what they are."""
    parts = [_line(INSET, 2, shown.width - INSET, 2, "track")]
    free = 0.0
    for value in ticks(shown):
        x, text = shown.place(value), significant(value, 3)
        parts.append(_line(x, 2, x, 6, "track"))
        if x - 0.5 * LETTER * len(text) >= free:
            parts.append(element("text", text, x=f"{x:.1f}", y=17, text_anchor="middle"))
            free = x + 0.5 * LETTER * (len(text) + 1)
    return _drawing(parts, shown.width, 20.0)


def ticks(shown: StripScale) -> list[float]:
    """Return round numbers inside a scale: two to five, or powers of ten."""
    if shown.log:
        first, last = -floor(-log10(shown.low)), floor(log10(shown.high))
        powers = [10.0**power for power in range(first, last + 1)]
        return powers if len(powers) > 1 else [value for value in _decade(shown) if shown.low <= value <= shown.high]
    span = shown.high - shown.low
    power = 10.0 ** floor(log10(span))
    most = 4.5 if shown.width == WIDTH else 2.5
    step = next((m * power for m in (0.1, 0.2, 0.5, 1.0, 2.0) if span / (m * power) < most), 5.0 * power)
    first = -floor(-shown.low / step + 1e-9)
    return [step * k for k in range(first, first + 6) if step * k <= shown.high + 1e-9 * span]


def _decade(shown: StripScale) -> list[float]:
    power = 10.0 ** floor(log10(shown.low))
    return [m * power for m in (1.0, 3.0, 10.0, 30.0, 100.0)]


def _whisker(shown: StripScale, estimate: Estimate, y: float, name: str) -> Markup:
    if estimate.low is None or estimate.high is None:
        return Markup()
    return _line(shown.place(estimate.low), y, shown.place(estimate.high), y, f"whisker {name}")


def _upright(shown: StripScale, value: float, name: str, height: float) -> Markup:
    return _line(shown.place(value), 0, shown.place(value), height, name)


def _line(x1: float, y1: float, x2: float, y2: float, name: str) -> Markup:
    ends = {key: f"{value:.1f}" for key, value in (("x1", x1), ("y1", y1), ("x2", x2), ("y2", y2))}
    return element("line", **ends, class_=name)


def _drawing(parts: Iterable[Markup], width: float, height: float) -> Markup:
    box = f"0 0 {width:g} {height:g}"
    size = {"width": f"{width:g}", "height": f"{height:g}"}
    return element("svg", join(parts), class_="strip", viewBox=box, **size, aria_hidden="true")
