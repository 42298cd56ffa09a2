"""Figures of contests: those of a comparison, and printed numbers against our flights."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from tuner.documents.comparison import ComparedFolder
from tuner.documents.comparison_document import PublishedRow
from tuner.extensions.contests.published_section import percentile_text, rows_of
from tuner.report.charts.chart import Line, Mark, Panel, Points, Words, row_axis, span_of, value_axis
from tuner.report.charts.look import Look, looks_of
from tuner.report.charts.paper import Figure, figure_of
from tuner.report.comparison.figures import FIGURES as COMPARED
from tuner.report.comparison.figures import Drawn

# Where printed numbers and ours span more than this factor, their axis is logarithmic.
LOG_FACTOR = 30.0
PERCENTILE = Look("ink", width=1.2)
INSIDE, OUTSIDE = Look("ink", "triangle-down", size=11), Look("ink", "triangle-down", hollow=True, size=11)
# How our flights are drawn below a printed number, whatever the colour of the contender.
CENTRAL, MEDIAN = Look("faint", width=7.5, opacity=0.6), Look("faint", "line-ns", size=20)
NOTHING = np.zeros(0)
LEGEND: tuple[Mark, ...] = (
    Line(name="central 95 % of our flights", look=CENTRAL, x=NOTHING, y=NOTHING),
    Points(name="their median", look=MEDIAN, x=NOTHING, y=NOTHING),
    Points(name="printed, inside", look=INSIDE, x=NOTHING, y=NOTHING),
    Points(name="printed, outside", look=OUTSIDE, x=NOTHING, y=NOTHING),
)
"""Names of the marks of printed numbers: marks without a place."""


def published_figure(contest: ComparedFolder) -> Figure | None:
    """Return our central 95 % of flights with each printed number; None where no number was printed."""
    panels = printed_panels(contest)
    if not panels:
        return None
    rows = max(len(panel.y.ticks) for panel in panels)
    note = "right: percentile of the printed number among our flights; *: the study was set to meet it"
    return figure_of(panels, min(2, len(panels)), max(0.75 + 0.18 * rows, 1.3), note=note)


def printed_panels(contest: ComparedFolder) -> list[Panel]:
    """Return a panel for each printed row, a line for each contender."""
    published = contest.shown.published
    groups = [[cell for cell in published if (cell.metric, cell.scenario) == row] for row in rows_of(published)]
    columns = min(2, len(groups))
    same = all([cell.contender for cell in cells] == [cell.contender for cell in groups[0]] for cells in groups)
    return [_printed(contest, cells, number % columns == 0 or not same) for number, cells in enumerate(groups)]


def _printed(contest: ComparedFolder, cells: Sequence[PublishedRow], named: bool) -> Panel:
    style, marks = looks_of(contest), list(LEGEND)
    for row, cell in enumerate(cells):
        look, (median, low, high) = style[cell.contender], cell.central
        if median is not None and low is not None and high is not None:
            bar = look._replace(width=CENTRAL.width, dash=(), opacity=0.35)
            marks.append(Line(look=bar, x=np.array([low, high]), y=np.full(2, -float(row))))
            middle = look._replace(symbol=MEDIAN.symbol, size=MEDIAN.size)
            marks.append(Points(look=middle, x=np.array([median]), y=np.array([-float(row)])))
        pin = INSIDE if cell.inside else OUTSIDE
        marks.append(Points(look=pin, x=np.array([cell.printed]), y=np.array([0.12 - row])))
        percentile = f"{percentile_text(cell.percentile)} %{'*' if cell.fitted else ''}"
        marks.append(Words(look=PERCENTILE, x=1.01, y=-float(row), text=percentile, place="right"))
    numbers = np.array([number for cell in cells for number in (*cell.central, cell.printed) if number is not None])
    span = span_of([numbers], LOG_FACTOR)
    # From zero where the numbers do not cover decades.
    axis = value_axis(
        cells[0].metric, cells[0].unit, span if span.log else span_of([np.append(numbers, 0.0)], LOG_FACTOR)
    )
    names = row_axis([cell.contender if named else "" for cell in cells])._replace(high=0.7)
    return Panel("", "", axis._replace(title=f"{axis.title}\nscenario {cells[0].scenario}"), names, marks, rows=True)


FIGURES: Drawn = {
    "front": COMPARED["front"],
    "differences": COMPARED["differences"],
    "published": published_figure,
    **COMPARED,
}
"""Figures by file name, in the order of writing."""


def figures_of(contest: ComparedFolder[Any]) -> dict[str, Any]:
    """Return the figures of a contest by name, drawn when called."""
    return {name: lambda draw=draw: draw(contest) for name, draw in FIGURES.items()}
