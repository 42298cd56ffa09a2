"""The chart of tails: the probability that a flight exceeds a level, on a logarithmic scale, with its 95 % band."""

from pathlib import Path

import numpy as np

from tuner.documents.tail import TailDocument, TailEvent
from tuner.report.charts.chart import Axis, Band, Line, Mark, Panel, Rule
from tuner.report.charts.files import save
from tuner.report.charts.look import COUNT, DASHES, RULE, Look
from tuner.report.charts.paper import Figure, figure_of, style
from tuner.text.units import bracketed, in_degrees

COLUMNS, HEIGHT, OPACITY = 2, 2.4, 0.18
SPREAD = 0.3
"""Share of the smallest probability at which the axis ends."""


def write_tail_figure(document: TailDocument, folder: Path) -> list[Path]:
    """Write tail.png and tail.pdf into a folder and return their paths."""
    with style():
        return save(tail_figure(document), folder, "tail")


def tail_figure(document: TailDocument) -> Figure:
    """Return the chart: a panel for each event, a line and a band for each of the gains."""
    count = len(document.gains[0].events)
    panels = [_panel(document, i) for i in range(count)]
    return figure_of(panels, min(count, COLUMNS), HEIGHT, titled=True)


def _panel(document: TailDocument, number: int) -> Panel:
    shown = [(gains.gains, gains.events[number]) for gains in document.gains]
    event = shown[0][1]
    unit, factor = in_degrees(event.unit)
    marks: list[Mark] = [Rule(look=RULE, axis="x", value=factor * event.limit)]
    for i, (name, each) in enumerate(shown):
        look = Look(f"c{i % COUNT}", dash=DASHES[i % COUNT])
        marks += _marks(each, factor, name if number == 0 else "", look)
    x = Axis(bracketed(event.metric or "demand over capacity", unit))
    least = max(min(document.smallest, *(each.probability or 1.0 for _, each in shown)), 1e-12)
    return Panel("", event.event, x, Axis("probability", SPREAD * least, 1.5, log=True), marks)


def _marks(event: TailEvent, factor: float, name: str, look: Look) -> list[Mark]:
    """Return line and band of an event where its probability is positive."""
    rows = np.array([(factor * each.level, each.probability, each.low, each.high) for each in event.curve]).reshape(
        -1, 4
    )
    level, probability, low, high = rows[rows[:, 1] > 0.0].T
    tiny = np.finfo(float).tiny
    return [
        Band(look=look._replace(opacity=OPACITY), x=level, low=np.maximum(low, tiny), high=high),
        Line(look=look, name=name, x=level, y=probability),
    ]
