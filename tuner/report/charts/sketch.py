"""A chart as a still drawing in the page: seen at once while the drawing library is unpacked, and where no scripts run."""

from tuner.report.charts.chart import Axis, Panel, Points
from tuner.report.charts.look import DEFAULT, SEARCHED, TUNED, drawn_mark
from tuner.report.charts.strip import StripScale, ticks
from tuner.text.markup import Markup, element, join
from tuner.text.numbers import significant

WIDTH, HEIGHT = 600.0, 420.0
# Ends of the area inside the axes [px].
LEFT, RIGHT, TOP, BOTTOM = 48.0, 590.0, 10.0, 378.0


def sketch(panel: Panel) -> Markup:
    """Return the points of a panel, but for what a search tried, with their intervals; both axes must have ends."""
    across, up = _scale(panel.x), _scale(panel.y)
    parts = []
    for value, text in _ticks(panel.x, across):
        x = _x(across, value)
        parts += [_line(x, TOP, x, BOTTOM, "grid"), _text(text, x, BOTTOM + 16.0, "middle")]
    for value, text in _ticks(panel.y, up):
        y = _y(up, value)
        parts += [_line(LEFT, y, RIGHT, y, "grid"), _text(text, LEFT - 6.0, y + 4.0, "end")]
    parts += [_line(LEFT, BOTTOM, RIGHT, BOTTOM, "track"), _line(LEFT, TOP, LEFT, BOTTOM, "track")]
    parts.append(_text(panel.x.title, (LEFT + RIGHT) / 2, HEIGHT - 6.0, "middle"))
    parts.append(_text(panel.y.title, -(TOP + BOTTOM) / 2, 12.0, "middle", transform="rotate(-90)"))
    for mark in panel.marks:
        if isinstance(mark, Points) and mark.look != SEARCHED:
            parts += _points(mark, across, up)
    return element("svg", join(parts), class_="sketch", viewBox=f"0 0 {WIDTH:g} {HEIGHT:g}", aria_hidden="true")


def _points(mark: Points, across: StripScale, up: StripScale) -> list[Markup]:
    """Return marks with whiskers; those beyond an axis stand at its end, default and tuned with their names."""
    look, whisker = mark.look, f"whisker {mark.look.colour}"
    places = [(_x(across, x), _y(up, y)) for x, y in zip(mark.x.tolist(), mark.y.tolist(), strict=True)]
    parts = []
    for ends, scale in ((mark.x_ends, across), (mark.y_ends, up)):
        for (x, y), low, high in zip(places, *ends, strict=True) if ends else ():
            if scale is across:
                parts.append(_line(_x(scale, low), y, _x(scale, high), y, whisker))
            else:
                parts.append(_line(x, _y(scale, low), x, _y(scale, high), whisker))
    parts += [drawn_mark(look, x, y, 1.4 * look.size) for x, y in places]
    if look in (DEFAULT, TUNED):
        parts += [_text(mark.name, x + 10.0, y - 6.0, "start") for x, y in places]
    return parts


def _scale(axis: Axis) -> StripScale:
    low, high = axis.ends or (0.0, 1.0)
    return StripScale(low, high, axis.log)


def _ticks(axis: Axis, scale: StripScale) -> list[tuple[float, str]]:
    return list(axis.ticks) or [(value, significant(value, 3)) for value in ticks(scale)]


def _x(scale: StripScale, value: float) -> float:
    return LEFT + (RIGHT - LEFT) * scale.share(value)


def _y(scale: StripScale, value: float) -> float:
    return BOTTOM - (BOTTOM - TOP) * scale.share(value)


def _line(x1: float, y1: float, x2: float, y2: float, name: str) -> Markup:
    return element("path", d=f"M{x1:.1f} {y1:.1f}L{x2:.1f} {y2:.1f}", class_=name)


def _text(text: str, x: float, y: float, anchor: str, **attributes: str) -> Markup:
    return element("text", text, x=f"{x:.1f}", y=f"{y:.1f}", text_anchor=anchor, **attributes)
