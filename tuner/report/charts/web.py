"""Charts for the page: traces and layouts of plotly.js as plain data, which js/chart.js completes.

Texts that begin with "@" or "#" have another meaning there: "@name" or "@name/0.3" is the colour --name of the style sheet
with an opacity, so that a chart follows the colour scheme; "#name" is an array of `Arrays`. `meta` of a trace is its `Show`.
"""

from base64 import b64encode
from collections.abc import Callable, Iterable, Sequence
from html import escape
from typing import Any, TypedDict

import numpy as np

from plant.texts import PlainTable
from tuner.report.charts.chart import (
    Array,
    Axis,
    Band,
    Bars,
    Disc,
    Line,
    Look,
    Mark,
    Panel,
    Points,
    Region,
    Rule,
    Words,
)
from tuner.text.markup import Markup, element, join

Plotly = PlainTable
"""An object of plotly.js, which describes its keys."""
Trace = Plotly
LARGEST = 65535
"""Largest number of sixteen bits; a step is 1/65535 of what a series spans, a hundredth of a pixel of a small chart."""


class Arrays:
    """Series of numbers, each stored once however often it is drawn: name -> packed, little-endian binary in base64."""

    def __init__(self) -> None:
        self.packed: Plotly = {}
        self._names: dict[Any, str] = {}

    def texts(self, values: Sequence[str]) -> str:
        """Store texts and return what represents them in a trace."""
        return self._name(tuple(values), lambda: list(values))

    def _name(self, key: Any, make: Callable[[], Any]) -> str:
        if key not in self._names:
            name = self._names[key] = f"#a{len(self._names)}"
            self.packed[name[1:]] = make()
        return self._names[key]

    def add(self, values: Array, coarse: bool = False) -> str:
        """Store a series (n,), in single precision, or coarsely in sixteen bits, and return what represents it in a trace."""
        values = np.ascontiguousarray(values, dtype=float)
        coarse = coarse and bool(np.isfinite(values).all())
        return self._name((coarse, values.tobytes()), lambda: quantised(values) if coarse else singles(values))


def singles(values: Array) -> str:
    """Return an array in row order as numbers of 32 bits, about seven digits."""
    return packed(values, "<f4")


class Quantized(TypedDict):
    """Numbers in sixteen bits. scale: lowest and step; packed: how many steps each is above."""

    scale: list[float]
    packed: str


def quantised(values: Array) -> Quantized:
    """Return finite numbers in sixteen bits on a scale from the smallest to the largest: value = low + step * q."""
    low, high = float(values.min(axis=None)), float(values.max(axis=None))
    step = (high - low) / LARGEST
    levels = np.zeros(values.shape) if step == 0.0 else np.clip(np.round((values - low) / step), 0, LARGEST)
    return {"scale": [low, step], "packed": packed(levels, "<u2")}


def packed(values: Array, kind: str) -> str:
    """Return an array of any shape in row order, as base64 of numbers of a kind such as "<f4"."""
    return b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")


def finite(values: Array) -> list[float | None]:
    """Return an array (n,) as a list for JSON: unrounded, None where it is not finite."""
    return [value if np.isfinite(value) else None for value in values.tolist()]


class WebPanel(TypedDict):
    """A panel as plotly.js draws it."""

    traces: list[Trace]
    layout: Plotly


def to_web(panel: Panel, arrays: Arrays) -> WebPanel:
    """Return a panel as {traces, layout}."""
    traces = [trace for mark in panel.marks for trace in _traces(mark, arrays)]
    shapes = [_shape(mark) for mark in panel.marks if isinstance(mark, Rule | Disc)]
    words = [_annotation(mark) for mark in panel.marks if isinstance(mark, Words)]
    return {"traces": traces, "layout": _layout(panel, shapes, words)}


class ChartData(TypedDict):
    """Charts of a page's script by the keys of their panels, and the arrays in them."""

    charts: dict[str, WebPanel]
    arrays: Plotly


def page_data(panels: Iterable[Panel]) -> ChartData:
    """Return the charts of a page with their arrays."""
    arrays = Arrays()
    return {"charts": {panel.key: to_web(panel, arrays) for panel in panels}, "arrays": arrays.packed}


def frame(panel: Panel) -> Markup:
    """Return the frame of a panel in the page: its heading, one line on how to read it, and the element it is drawn in."""
    head = term(panel.title, panel.tip) if panel.tip else panel.title
    caption = element("figcaption", join((head, element("small", panel.aid, class_="reading") if panel.aid else "")))
    drawn = element("div", id=panel.key, class_="chart", role="img", aria_label=f"{panel.title}. {panel.aid}".strip())
    return element("figure", caption, drawn, class_=panel.form)


def grid(panels: Sequence[Panel], name: str) -> Markup:
    """Return the frames of panels side by side; name: the classes of the grid."""
    return element("div", *[frame(panel) for panel in panels], class_=f"grid {name}")


def term(text: str, definition: str) -> Markup:
    """Return a word whose definition is shown under the pointer and on focus."""
    return element("span", text, class_="term", tabindex="0", data_tip=definition)


def line_of(look: Look, width: float | None = None) -> dict[str, str | float]:
    """Return the line of a look for plotly.js."""
    dash = ",".join(f"{length:g}px" for length in look.dash) or "solid"
    return {"width": look.width if width is None else width, "color": f"@{look.colour}", "dash": dash}


def marker_of(look: Look) -> Plotly:
    """Return the marker of a look for plotly.js."""
    thin = look.symbol.endswith("thin") or look.symbol.startswith("line-")
    symbol = "circle" if look.symbol == "dot" else look.symbol + ("-open" if look.hollow else "")
    width = look.width if look.hollow or thin else 0
    line = {"width": width, "color": f"@{look.colour}"}
    return {"symbol": symbol, "size": look.size, "color": f"@{look.colour}", "line": line, "opacity": look.opacity}


def _traces(mark: Mark, arrays: Arrays) -> list[Trace]:
    match mark:
        case Points():
            return _points(mark, arrays)
        case Line():
            return [_line(mark, arrays)]
        case Band():
            return _band(mark, arrays)
        case Bars():
            return [_bars(mark, arrays)]
        case Region():
            return [_region(mark)]
    return []


def _points(mark: Points, arrays: Arrays) -> list[Trace]:
    base = {"x": arrays.add(mark.x), "y": arrays.add(mark.y), "meta": mark.show}
    traces = []
    if mark.x_ends or mark.y_ends:
        bars = {
            f"error_{name}": _reach(getattr(mark, name), ends, mark.look, arrays)
            for name, ends in (("x", mark.x_ends), ("y", mark.y_ends))
            if ends
        }
        shown = {**base, "mode": "markers", "marker": {"size": 1, "color": "rgba(0,0,0,0)"}, "hoverinfo": "skip"}
        traces.append({**shown, "meta": {**mark.show, "part": "intervals"}, "opacity": 0.6, **bars})
    trace = {**base, "mode": "markers", "marker": marker_of(mark.look), "name": escape(mark.name, quote=False)}
    if len(mark.labels):
        trace["ids"] = list(mark.labels)
    if len(mark.hover):
        trace |= {"hovertext": arrays.texts(mark.hover), "hovertemplate": "%{hovertext}<extra></extra>"}
    else:
        trace["hoverinfo"] = "skip"
    if len(mark.texts):
        trace |= {
            "mode": "markers+text",
            "text": [escape(text, quote=False) for text in mark.texts],
            "cliponaxis": False,
        }
        trace["textfont"] = {"color": f"@{mark.look.colour}", "size": 13}
        trace["textposition"] = mark.place
    return [*traces, trace]


def _reach(values: Array, ends: tuple[Array, Array], look: Look, arrays: Arrays) -> Plotly:
    down, up = np.maximum(values - ends[0], 0.0), np.maximum(ends[1] - values, 0.0)
    bars = {
        "type": "data",
        "symmetric": False,
        "width": 0,
        "thickness": 3 if look.width > 2.0 else 1,
        "color": f"@{look.colour}",
    }
    return {**bars, "array": arrays.add(up), "arrayminus": arrays.add(down)}


def _line(mark: Line, arrays: Arrays) -> Trace:
    trace: Trace = {
        "mode": "lines" if mark.marked is None else "lines+markers",
        # Of a track both coordinates are as coarse as in the charts over time, whose numbers it shares; a time stays exact.
        "x": arrays.add(mark.x, mark.coarse and bool(np.any(np.diff(mark.x) <= 0.0))),
        "y": arrays.add(mark.y, mark.coarse),
    }
    trace |= {"line": line_of(mark.look) | ({"shape": "hv"} if mark.steps else {}), "meta": mark.show}
    if mark.marked is not None:
        trace["marker"] = {**marker_of(mark.look), "size": 5}
    if mark.tips:
        trace["customdata"] = {"zip": [arrays.add(series, mark.coarse) for series in mark.tips]}
    if mark.tip:
        trace["hovertemplate"] = f"{escape(mark.name)}{': ' if mark.name else ''}{mark.tip}<extra></extra>"
    else:
        trace["hoverinfo"] = "skip"
    return trace


def _band(mark: Band, arrays: Arrays) -> list[Trace]:
    """Lower and upper edge, filled in between; they must stay neighbours."""
    x, low, high = arrays.add(mark.x), arrays.add(mark.low, mark.coarse), arrays.add(mark.high, mark.coarse)
    edge = {"mode": "lines", "x": x, "line": {"width": 0}, "hoverinfo": "skip", "meta": mark.show}
    fill = {"fill": "tonexty", "fillcolor": f"@{mark.look.colour}/{mark.look.opacity:g}"}
    return [{**edge, "y": low}, {**edge, "y": high, **fill}]


def _bars(mark: Bars, arrays: Arrays) -> Trace:
    trace = {
        "type": "bar",
        "x": arrays.add(mark.x),
        "y": arrays.add(mark.y),
        "name": escape(mark.name),
        "meta": mark.show,
    }
    pattern = {"shape": mark.look.symbol, "fgcolor": f"@{mark.look.colour}", "size": 5, "solidity": 0.25}
    trace["marker"] = {"color": f"@{mark.look.colour}/0.6"} | ({"pattern": pattern} if mark.look.symbol in "/x" else {})
    trace["hovertemplate"] = f"{escape(mark.name)}{': ' if mark.name else ''}%{{y:,.0f}}<extra></extra>"
    if len(mark.labels):
        trace |= {"ids": list(mark.labels), "text": [escape(label) for label in mark.labels], "textposition": "none"}
        trace["hovertemplate"] = "%{text}: %{y:.0f} %<extra></extra>"
    return trace


def _region(mark: Region) -> Trace:
    return {
        "type": "contour",
        "x": finite(mark.x),
        "y": finite(mark.y),
        "z": [finite(row) for row in mark.values],
        "contours": {"type": "constraint", "operation": "[]", "value": list(mark.ends)},
        "line": line_of(mark.look),
        "fillcolor": f"@{mark.look.colour}/{mark.look.opacity:g}",
        "name": escape(mark.name),
        "meta": mark.show,
        "hoverinfo": "skip",
    }


def _shape(mark: Rule | Disc) -> Plotly:
    line = line_of(mark.look)
    if isinstance(mark, Disc):
        ends = {
            "x0": mark.x - mark.radius,
            "x1": mark.x + mark.radius,
            "y0": mark.y - mark.radius,
            "y1": mark.y + mark.radius,
        }
        fill = {"fillcolor": f"@{mark.look.colour}/0.12"} if mark.fill else {}
        return {"type": "circle", **ends, "line": line, "layer": "below", **fill, **_shown(mark)}
    other = "y" if mark.axis == "x" else "x"
    ends = {f"{mark.axis}0": mark.value, f"{mark.axis}1": mark.value, f"{other}0": 0, f"{other}1": 1}
    return {"type": "line", **ends, f"{other}ref": "paper", "line": line, **_shown(mark)}


def _annotation(mark: Words) -> Plotly:
    font = {"color": f"@{mark.look.colour}", "size": 11}
    return {
        "x": mark.x,
        "y": mark.y,
        "text": escape(mark.text, quote=False),
        "showarrow": False,
        "font": font,
        "meta": mark.show,
        **({"xref": "paper", "yref": "paper", "xanchor": "right"} if mark.place == "inside" else {}),
    }


def _shown(mark: Mark) -> Plotly:
    return {"meta": mark.show} if mark.show else {}


def _layout(panel: Panel, shapes: list[Plotly], words: list[Plotly]) -> Plotly:
    # A square panel keeps the ends of its axes: its plot area becomes as narrow as they ask for.
    fitted = {"constrain": "domain"} if panel.square else {}
    square = {"scaleanchor": "x"} if panel.square else {}
    layout: Plotly = {"xaxis": _axis(panel.x) | fitted, "yaxis": _axis(panel.y) | square | fitted}
    if shapes:
        layout["shapes"] = shapes
    if words:
        layout["annotations"] = words
    if panel.hides:
        layout["meta"] = {"hides": True}
    if panel.across:
        layout["hovermode"] = "x"
    if panel.stacked:
        layout["barmode"] = "stack"
    if panel.legend:
        layout |= {"showlegend": True, "legend": {"orientation": "h", "y": 1.15, "x": 0, "font": {"size": 11}}}
    return layout


def _axis(axis: Axis) -> Plotly:
    made: Plotly = {"title": {"text": escape(axis.title, quote=False)}}
    if axis.log:
        made["type"] = "log"
    if axis.ends:
        made["range"] = np.log10(axis.ends).tolist() if axis.log else list(axis.ends)
    if axis.ticks:
        made |= {"tickvals": [value for value, _ in axis.ticks], "nticks": 0}
        made["ticktext"] = [escape(text, quote=False) for _, text in axis.ticks]
    if axis.step:
        made["dtick"] = axis.step
    return made
