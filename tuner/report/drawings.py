"""Small drawings inside table rows: intervals on a common scale, and where a gain lies in its range.

The numbers stand beside them, so they are hidden from screen readers. Colours and strokes come from page.css.
"""

from collections.abc import Callable
from math import isfinite, log

from tuner.documents.parts import Estimate
from tuner.documents.results import Quantity, Required, Variable
from tuner.text.markup import Markup, element, join

WIDTH, INSET = 160.0, 8.0


def square(x: float, y: float) -> Markup:
    """Return the mark of the default."""
    return element("rect", x=f"{x - 4:.1f}", y=f"{y - 4:.1f}", width=8, height=8, class_="mark-default")


def diamond(x: float, y: float) -> Markup:
    """Return the mark of the tuned point."""
    path = f"M{x:.1f} {y - 6:.1f}l6 6l-6 6l-6 -6z"
    return element("path", d=path, class_="mark-tuned")


def intervals(quantity: Quantity | Required) -> Markup:
    """Draw default (above) and tuned (below), with their intervals, on a scale from zero, and the limit."""
    numbers = [*quantity.default, *quantity.tuned, quantity.limit]
    known = [number for number in numbers if number is not None and isfinite(number)]
    low, high = min(0.0, *known, 0.0), max(0.0, *known, 0.0)
    span = high - low or 1.0

    def place(number: float) -> float:
        return INSET + (WIDTH - 2 * INSET) * (number - low) / span

    parts = [_line(place(0.0), 2, place(0.0), 38, "zero")]
    if quantity.limit is not None:
        parts.append(_line(place(quantity.limit), 2, place(quantity.limit), 38, "limit"))
    for estimate, y, mark, name in ((quantity.default, 12, square, "default"), (quantity.tuned, 28, diamond, "tuned")):
        parts.append(_whisker(estimate, y, name, place))
        if estimate.value is not None:
            parts.append(mark(place(estimate.value), y))
    return _drawing(parts, 40)


def position(variable: Variable) -> Markup:
    """Draw where default and tuned lie in the search range, on the scale that the search walks."""
    parts = [_line(INSET, 14, WIDTH - INSET, 14, "track")]
    parts += [_line(x, 9, x, 19, "track") for x in (INSET, WIDTH - INSET)]
    for value, mark in ((variable.default, square), (variable.tuned, diamond)):
        parts.append(mark(INSET + (WIDTH - 2 * INSET) * share(variable, value), 14))
    return _drawing(parts, 28)


def share(variable: Variable, value: float) -> float:
    """Return where a value lies in the search range: 0 at its low end, 1 at its high end; ends where it is outside."""
    inside = min(max(value, variable.low), variable.high)
    if variable.scale == "log":
        return log(inside / variable.low) / log(variable.high / variable.low)
    return (inside - variable.low) / (variable.high - variable.low)


def _whisker(estimate: Estimate, y: float, name: str, place: Callable[[float], float]) -> Markup:
    if estimate.low is None or estimate.high is None:
        return Markup()
    return _line(place(estimate.low), y, place(estimate.high), y, f"whisker-{name}")


def _line(x1: float, y1: float, x2: float, y2: float, name: str) -> Markup:
    ends = {key: f"{value:.1f}" for key, value in (("x1", x1), ("y1", y1), ("x2", x2), ("y2", y2))}
    return element("line", **ends, class_=name)


def _drawing(parts: list[Markup], height: int) -> Markup:
    box = f"0 0 {WIDTH:g} {height}"
    return element("svg", join(parts), class_="drawing", viewBox=box, width=WIDTH, height=height, aria_hidden="true")
