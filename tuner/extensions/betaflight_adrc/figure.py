"""The front of tunes by margin: bandwidth against margin and noise, a line for each axis."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from plant.errors import InputError
from tuner.extensions.betaflight_adrc.document import DesignRow
from tuner.report.charts.chart import Line, Panel, Points, span_of, value_axis
from tuner.report.charts.look import looks
from tuner.report.charts.paper import figure_of, printed, style
from tuner.store.folder import put

HEIGHT = 2.4
"""Height of the figure [in]."""
QUANTITIES = (("gain_margin", "gain margin at every throttle"), ("noise", "noise, over the file's tune"))
"""Field of a row -> its axis."""


def front_panels(rows: Sequence[DesignRow], wanted: float) -> list[Panel]:
    """Return a panel for the margin and one for the noise; filled marks are the tunes with the wanted margin."""
    axes = list(dict.fromkeys(row.axis for row in rows))
    styles = dict(zip(axes, looks([(axis, "") for axis in axes]), strict=True))
    bandwidths = np.array([row.bandwidth for row in rows])
    panels = []
    for name, title in QUANTITIES:
        marks: list[Line | Points] = []
        for axis, look in styles.items():
            selected = [row for row in rows if row.axis == axis]
            x = np.array([row.bandwidth for row in selected])
            y = np.array([getattr(row, name) for row in selected])
            chosen = np.array([row.wanted == wanted for row in selected])
            marks.append(Line(look=look, name=axis, x=x, y=y))
            marks.append(Points(look=look._replace(hollow=True, size=6), x=x[~chosen], y=y[~chosen]))
            marks.append(Points(look=look, x=x[chosen], y=y[chosen]))
        values = np.array([getattr(row, name) for row in rows])
        spans = (value_axis("bandwidth", "Hz", span_of([bandwidths], 20.0)), span_of([values], 20.0).axis(title))
        panels.append(Panel(f"front.{name}", title, *spans, marks))
    return panels


def write_front(path: Path, rows: Sequence[DesignRow], wanted: float) -> None:
    """Write the front as a new PNG or PDF; raises InputError for another name."""
    if path.suffix not in (".png", ".pdf"):
        raise InputError("give a name that ends in .png or .pdf", key="--front")
    if path.exists():
        raise InputError(f"{path} exists already and was not touched; give another name", key="--front")
    with style():
        put(path.parent, path.name, printed(figure_of(front_panels(rows, wanted), 2, HEIGHT))[path.suffix])
