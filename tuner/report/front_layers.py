"""The layers of a figure of the front: who is shown, with which text under the pointer."""

from html import escape
from typing import NamedTuple

import numpy as np

from tuner.report.chart import Charts
from tuner.report.numbers import estimate, significant
from tuner.report.results import DEFAULT, Quantity, Results
from tuner.report.units import plain

# Search candidates drawn at most of each kind; more only blacken the paper and slow the page.
MOST_CANDIDATES = 1200


class Layer(NamedTuple):
    """Points of one kind.

    names (n,); values (n, objectives); low, high: their intervals, None for search values; hover: name of the shared
    array of texts; size: of the marker [px].
    """

    kind: str
    names: list[str]
    values: np.ndarray
    low: np.ndarray | None
    high: np.ndarray | None
    hover: str
    size: float


def layers(results: Results, charts: Charts) -> list[Layer]:
    """Return the layers from back to front, empty ones left out."""
    front = results.front
    named = np.array([role != "" for role in front.roles])
    rows = {
        "finalist": ~front.non_dominated & ~named,
        "front": front.non_dominated & ~named,
        "default": np.array([role == "default" for role in front.roles]),
        "tuned": np.array([role == "tuned" for role in front.roles]),
    }
    sizes = {"finalist": 7, "front": 7, "default": 11, "tuned": 12}
    found = [_search_layer(results, charts, kind) for kind in ("infeasible", "searched")]
    for kind, mask in rows.items():
        shown = np.flatnonzero(mask).tolist()
        hover = charts.share(f"hover-{kind}", [point_text(results, row) for row in shown])
        names = [front.points[row] for row in shown]
        found.append(Layer(kind, names, front.held_out[mask], front.low[mask], front.high[mask], hover, sizes[kind]))
    return [layer for layer in found if len(layer.values)]


def thinned(rows: np.ndarray, most: int) -> np.ndarray:
    """Return at most so many of the rows, evenly spread."""
    if len(rows) <= most:
        return rows
    return rows[np.linspace(0, len(rows) - 1, most).round().astype(int)]


def _search_layer(results: Results, charts: Charts, kind: str) -> Layer:
    tried, front = results.candidates, results.front
    flown = front.candidates[[role != "default" for role in front.roles]]
    wanted = tried.feasible & ~np.isin(tried.number, flown) if kind == "searched" else ~tried.feasible
    rows = thinned(np.flatnonzero(wanted), MOST_CANDIDATES)
    hover = charts.share(f"hover-{kind}", [_candidate_text(results, row, kind) for row in rows.tolist()])
    return Layer(kind, [str(number) for number in tried.number[rows]], tried.values[rows], None, None, hover, 4)


def point_text(results: Results, row: int) -> str:
    """Return the text under the pointer of a point flown on held-out scenarios."""
    front = results.front
    state = [front.roles[row] if front.roles[row] != front.points[row] else ""]
    state.append("" if front.feasible[row] else "breaks a constraint")
    state.append("dominated" if front.feasible[row] and not front.non_dominated[row] and not front.roles[row] else "")
    head = ", ".join([f"<b>{escape(front.points[row])}</b>", *[entry for entry in state if entry]])
    lines = [
        _value_line(quantity, *estimate(front.held_out[row, i], front.low[row, i], front.high[row, i]))
        for i, quantity in enumerate(results.objectives)
    ]
    if front.probability is not None and front.roles[row] != DEFAULT:
        lines.append(f"non-dominated on {100.0 * front.probability[row]:.0f} % of the resamples")
    return "<br>".join([f"{head} (held-out)", *lines, *_gain_lines(results, front.gains[row])])


def _candidate_text(results: Results, row: int, kind: str) -> str:
    tried = results.candidates
    head = f"<b>candidate {tried.number[row]}</b>{', breaks a constraint' if kind == 'infeasible' else ''} (search)"
    lines = [_value_line(entry, significant(tried.values[row, i], 3)) for i, entry in enumerate(results.objectives)]
    return "<br>".join([head, *lines, *_gain_lines(results, tried.gains[row])])


def _value_line(quantity: Quantity, value: str, interval: str = "") -> str:
    return escape(" ".join(part for part in (f"{quantity.label}:", value, interval, plain(quantity.unit)) if part))


def _gain_lines(results: Results, gains: np.ndarray) -> list[str]:
    return [
        escape(f"{entry.name} = {significant(gain, 3)}")
        for entry, gain in zip(results.variables, gains.tolist(), strict=True)
    ]
