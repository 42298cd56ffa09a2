"""Rows under one axis: paired differences, values of all contenders, and printed numbers against our flights."""

from collections.abc import Sequence

import numpy as np

from tuner.documents.contest import ComparedFolder
from tuner.documents.contest_document import DifferenceRow, PublishedRow, QuantityRow
from tuner.documents.parts import Estimate
from tuner.report.charts.chart import Axis, Line, Mark, Panel, Points, Rule, Words, row_axis, span_of, value_axis
from tuner.report.charts.look import BOUND, Look, looks_of
from tuner.report.contest.differences_section import related
from tuner.report.contest.published_section import percentile_text, rows_of
from tuner.report.labels import has_rotors, plain_label
from tuner.text.units import bracketed

# Panels drawn at most, objectives first.
MAX_PANELS = 15
# Where printed numbers and ours span more than this factor, their axis is logarithmic.
LOG_FACTOR = 30.0
ZERO = Look("ink", width=1.2)
CLEAR, UNCLEAR = Look("ink", "diamond"), Look("ink", "diamond", hollow=True)
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


def difference_panels(contest: ComparedFolder, columns: int) -> list[Panel]:
    """Return a forest for each quantity in which contenders differ, a row for each pair of kin; names at the left of each row."""
    pairs_by_quantity = [(quantity, _pairs(contest, quantity.label)) for quantity in contest.shown.quantities]
    shown = [entry for entry in pairs_by_quantity if any(number for pair in entry[1] for number in pair.estimate)][
        :MAX_PANELS
    ]
    return [_forest(contest, quantity, pairs, number % columns == 0) for number, (quantity, pairs) in enumerate(shown)]


def value_panels(contest: ComparedFolder, columns: int) -> list[Panel]:
    """Return a panel for each quantity, a row for each contender."""
    style, panels = looks_of(contest), []
    for number, quantity in enumerate(contest.shown.quantities[:MAX_PANELS]):
        marks: list[Mark] = []
        for row, entry in enumerate(contest.contenders):
            marks += _estimate(contest.estimates[entry.name, quantity.label], row, style[entry.name])
        if quantity.limit is not None:
            marks.append(Rule(look=BOUND, axis="x", value=quantity.limit))
        names = [entry.name if number % columns == 0 else "" for entry in contest.contenders]
        panels.append(Panel("", "", Axis(_title(contest, quantity)), row_axis(names), marks, rows=True))
    return panels


def printed_panels(contest: ComparedFolder) -> list[Panel]:
    """Return a panel for each row of the printed table, a row for each contender."""
    published = contest.shown.published
    groups = [[cell for cell in published if (cell.metric, cell.scenario) == row] for row in rows_of(published)]
    columns = min(2, len(groups))
    same = all([cell.contender for cell in cells] == [cell.contender for cell in groups[0]] for cells in groups)
    return [_printed(contest, cells, number % columns == 0 or not same) for number, cells in enumerate(groups)]


def _pairs(contest: ComparedFolder, label: str) -> list[DifferenceRow]:
    return [entry for entry in contest.shown.differences if entry.quantity == label and related(contest, entry)]


def _forest(contest: ComparedFolder, quantity: QuantityRow, pairs: Sequence[DifferenceRow], named: bool) -> Panel:
    marks: list[Mark] = [Rule(look=ZERO, axis="x", value=0.0)]
    for row, entry in enumerate(pairs):
        marks += _estimate(entry.estimate, row, UNCLEAR if entry.lower is None else CLEAR)
    names = [f"{entry.second} − {entry.first}" if named else "" for entry in pairs]
    return Panel("", "", Axis(_title(contest, quantity)), row_axis(names), marks, rows=True)


def _estimate(estimate: Estimate, row: int, look: Look) -> list[Mark]:
    if estimate.value is None or estimate.low is None or estimate.high is None:
        return []
    place = np.array([estimate.value]), np.array([-float(row)])
    return [Points(look=look, x=place[0], y=place[1], x_ends=(np.array([estimate.low]), np.array([estimate.high])))]


def _title(contest: ComparedFolder, quantity: QuantityRow) -> str:
    where = "" if quantity.scenario is None else f"scenario {quantity.scenario}"
    name = plain_label(quantity.label, quantity.metric, None, has_rotors(contest), short=True)
    return f"{bracketed(name, quantity.unit)}\n{where}"


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
        marks.append(Words(look=ZERO, x=1.01, y=-float(row), text=percentile, place="right"))
    numbers = np.array([number for cell in cells for number in (*cell.central, cell.printed) if number is not None])
    span = span_of([numbers], LOG_FACTOR)
    # From zero where the numbers do not cover decades.
    axis = value_axis(
        cells[0].metric, cells[0].unit, span if span.log else span_of([np.append(numbers, 0.0)], LOG_FACTOR)
    )
    names = row_axis([cell.contender if named else "" for cell in cells])._replace(high=0.7)
    return Panel("", "", axis._replace(title=f"{axis.title}\nscenario {cells[0].scenario}"), names, marks, rows=True)
