"""How each metric scatters over flights: the empirical distribution function of every contender in one figure."""

from html import escape

import numpy as np

from tuner.documents.contest import Contest, Quantity, Scores
from tuner.documents.look import plotly_line
from tuner.report.chart import Charts, Panel, Trace, axis, layout, listed
from tuner.report.contest.spans import span_of
from tuner.text.units import bracketed, plain

# Steps of a drawn function at most; a figure is some 400 pixels wide.
MOST_STEPS = 200
# Share of the worst flights that need not be shown: a failed flight costs more than any completed one.
TAIL = 0.01


def add_distributions(contest: Contest, charts: Charts) -> list[Panel]:
    """Add a figure for each metric and scenario that varies over flights and return their panels."""
    panels = []
    for number, quantity in enumerate(_metrics(contest)):
        found = [
            entry for entry in contest.scores if entry.quantity == quantity.label and entry.contender in contest.look
        ]
        if not found or all(entry.values[0] == entry.values[-1] for entry in found):
            continue
        name = f"distribution-{number}"
        traces = [_curve(contest, entry, plain(quantity.unit)) for entry in found]
        shown = span_of(np.quantile(entry.values, [0.0, 1.0 - TAIL], axis=0) for entry in found)
        x = axis(bracketed(quantity.metric, quantity.unit), **shown.plotly())
        charts.add(name, traces, layout(x, axis("flights [%]", range=[-2, 102])))
        where = "all scenarios" if quantity.scenario is None else f"scenario {quantity.scenario}"
        panels.append(Panel(name, "axis", f"{quantity.metric}, {where}"))
    return panels


def steps(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return places (k,) and shares (k,) [%] of the distribution function of sorted values (n,), thinned to k steps.

    The smallest and the largest value always stay.
    """
    rows = np.unique(np.linspace(0, len(values) - 1, min(len(values), MOST_STEPS)).round().astype(int))
    return values[rows], 100.0 * (rows + 1) / len(values)


def _metrics(contest: Contest) -> list[Quantity]:
    """Return one quantity for each metric and scenario: different risks of one metric have the same flights behind them."""
    found = {(entry.metric, entry.scenario): entry for entry in reversed(contest.quantities)}
    return [entry for entry in contest.quantities if found[entry.metric, entry.scenario] is entry]


def _curve(contest: Contest, entry: Scores, unit: str) -> Trace:
    x, y = steps(entry.values)
    text = f"{escape(entry.contender)}: %{{y:.3~g}} % of flights at most %{{x:.4~g}} {escape(unit)}<extra></extra>"
    return {
        "type": "scatter", "mode": "lines", "x": listed(np.append(x[0], x)), "y": listed(np.append(0.0, y)),
        "line": {**plotly_line(contest.look[entry.contender]), "shape": "hv"}, "hovertemplate": text,
        "meta": {"layer": contest.layer(entry.contender)},
    }  # fmt: skip
