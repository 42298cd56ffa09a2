"""Rows under one axis: paired differences, and values of all contenders."""

from collections.abc import Sequence

import numpy as np

from tuner.documents.comparison import ComparedFolder
from tuner.documents.comparison_document import DifferenceRow, QuantityRow
from tuner.documents.parts import Estimate
from tuner.report.charts.chart import Axis, Mark, Panel, Points, Rule, row_axis
from tuner.report.charts.look import BOUND, Look, looks_of
from tuner.report.comparison.differences_section import related
from tuner.report.labels import channels_of, plain_label
from tuner.text.units import bracketed

# Panels drawn at most, objectives first.
MAX_PANELS = 15
ZERO = Look("ink", width=1.2)
CLEAR, UNCLEAR = Look("ink", "diamond"), Look("ink", "diamond", hollow=True)


def difference_panels(compared: ComparedFolder, columns: int) -> list[Panel]:
    """Return a forest for each quantity in which contenders differ, a row for each pair of kin; names at the left of each row."""
    pairs_by_quantity = [(quantity, _pairs(compared, quantity.label)) for quantity in compared.shown.quantities]
    shown = [entry for entry in pairs_by_quantity if any(number for pair in entry[1] for number in pair.estimate)][
        :MAX_PANELS
    ]
    return [_forest(compared, quantity, pairs, number % columns == 0) for number, (quantity, pairs) in enumerate(shown)]


def value_panels(compared: ComparedFolder, columns: int) -> list[Panel]:
    """Return a panel for each quantity, a row for each contender."""
    style, panels = looks_of(compared), []
    for number, quantity in enumerate(compared.shown.quantities[:MAX_PANELS]):
        marks: list[Mark] = []
        for row, entry in enumerate(compared.contenders):
            marks += _estimate(compared.estimates[entry.name, quantity.label], row, style[entry.name])
        if quantity.limit is not None:
            marks.append(Rule(look=BOUND, axis="x", value=quantity.limit))
        names = [entry.name if number % columns == 0 else "" for entry in compared.contenders]
        panels.append(Panel("", "", Axis(_title(compared, quantity)), row_axis(names), marks, rows=True))
    return panels


def _pairs(compared: ComparedFolder, label: str) -> list[DifferenceRow]:
    return [entry for entry in compared.shown.differences if entry.quantity == label and related(compared, entry)]


def _forest(compared: ComparedFolder, quantity: QuantityRow, pairs: Sequence[DifferenceRow], named: bool) -> Panel:
    marks: list[Mark] = [Rule(look=ZERO, axis="x", value=0.0)]
    for row, entry in enumerate(pairs):
        marks += _estimate(entry.estimate, row, UNCLEAR if entry.lower is None else CLEAR)
    names = [f"{entry.second} − {entry.first}" if named else "" for entry in pairs]
    return Panel("", "", Axis(_title(compared, quantity)), row_axis(names), marks, rows=True)


def _estimate(estimate: Estimate, row: int, look: Look) -> list[Mark]:
    if estimate.value is None or estimate.low is None or estimate.high is None:
        return []
    place = np.array([estimate.value]), np.array([-float(row)])
    return [Points(look=look, x=place[0], y=place[1], x_ends=(np.array([estimate.low]), np.array([estimate.high])))]


def _title(compared: ComparedFolder, quantity: QuantityRow) -> str:
    where = "" if quantity.scenario is None else f"scenario {quantity.scenario}"
    name = plain_label(quantity.label, quantity.metric, None, channels_of(compared), short=True)
    return f"{bracketed(name, quantity.unit)}\n{where}"
