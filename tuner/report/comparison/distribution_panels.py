"""Scatter of each metric over flights: the empirical distribution function of every contender."""

import numpy as np

from tuner.documents.comparison import ComparedFolder, ContenderScores
from tuner.documents.comparison_document import QuantityRow
from tuner.report.charts.chart import Axis, Line, Mark, Panel, span_of, value_axis
from tuner.report.charts.look import looks_of
from tuner.report.labels import channels_of, plain_metric
from tuner.text.units import plain

# Steps of a drawn function at most; a chart is some 400 pixels wide.
MAX_STEPS = 200
# Share of the worst flights that need not be shown: a failed flight costs more than any completed one.
TAIL = 0.01
# Where the shown values span more than this factor, a linear axis would press most of them into a corner.
LOG_FACTOR = 25.0
SHARE = Axis("share [%]", -2.0, 102.0)


def distribution_panels(compared: ComparedFolder) -> list[Panel]:
    """Return a panel for each metric and scenario that varies over flights."""
    style, panels = looks_of(compared), []
    for number, quantity in enumerate(_metrics(compared)):
        scores = [entry for entry in compared.scores if entry.quantity == quantity.label and entry.contender in style]
        if not scores or all(entry.values[0] == entry.values[-1] for entry in scores):
            continue
        shown = span_of([np.quantile(entry.values, [0.0, 1.0 - TAIL], axis=0) for entry in scores], LOG_FACTOR)
        where = "all scenarios" if quantity.scenario is None else f"scenario {quantity.scenario}"
        marks = [_curve(compared, entry, plain(quantity.unit)) for entry in scores]
        name = plain_metric(quantity.metric, channels_of(compared))
        x = value_axis(name, quantity.unit, shown)
        panels.append(Panel(f"distribution-{number}", f"{name}, {where}", x, SHARE, marks, tip=quantity.metric))
    return panels


def steps(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return places (k,) and shares (k,) [%] of the distribution function of sorted values (n,), thinned to k steps.

    The smallest and the largest value always stay.
    """
    rows = np.unique(np.linspace(0, len(values) - 1, min(len(values), MAX_STEPS)).round().astype(int))
    return values[rows], 100.0 * (rows + 1) / len(values)


def _metrics(compared: ComparedFolder) -> list[QuantityRow]:
    """Return one quantity for each metric and scenario: different risks of one metric have the same flights behind them."""
    last = {(entry.metric, entry.scenario): entry for entry in reversed(compared.shown.quantities)}
    return [entry for entry in compared.shown.quantities if last[entry.metric, entry.scenario] is entry]


def _curve(compared: ComparedFolder, entry: ContenderScores, unit: str) -> Mark:
    x, y = steps(entry.values)
    return Line(
        name=entry.contender,
        look=looks_of(compared)[entry.contender],
        x=np.append(x[0], x),
        y=np.append(0.0, y),
        steps=True,
        tip=f"%{{y:.3~g}} % at most %{{x:.4~g}} {unit}",
        show={"layer": compared.layer(entry.contender)},
    )
