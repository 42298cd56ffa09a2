"""The fronts of all contenders over each other: a panel for each pair of objectives, with intervals, gains under the pointer."""

from collections.abc import Sequence
from html import escape
from itertools import combinations

import numpy as np

from tuner.documents.comparison import ComparedFolder, ContenderFront
from tuner.documents.comparison_document import FrontsPart
from tuner.report.charts.chart import AxisRange, Line, Mark, Panel, Points, row_axis, span_of, value_axis
from tuner.report.charts.front import lost_points
from tuner.report.charts.look import Look, looks_of
from tuner.report.comparison.contenders_section import Gain, joined
from tuner.report.labels import compared_label
from tuner.text.numbers import estimate, significant
from tuner.text.sentences import counted
from tuner.text.units import plain

# Projections drawn at most: those of five objectives.
MAX_PAIRS = 10
# FrontsPart are much like hyperbolas: they stand apart on logarithmic axes, and huddle in a corner of others.
LOG_FACTOR = 5.0
RING = Look("ink", hollow=True, size=20)
# Where the names of recommended points stand, one contender after the other: such points are often neighbours.
PLACES = ("top right", "bottom left", "bottom right", "top left")


def fronts_panels(compared: ComparedFolder) -> list[Panel]:
    """Return a panel for each pair of objectives, or a ranking."""
    fronts = compared.fronts
    if fronts is None or not compared.front_points:
        return []
    count = len(fronts.objectives)
    if count == 1:
        return [_ranking(compared, fronts)]
    pairs = list(combinations(range(count), 2))[:MAX_PAIRS]
    return [_pair(compared, fronts, i, j) for i, j in pairs]


def hover_texts(compared: ComparedFolder, fronts: FrontsPart, front: ContenderFront) -> list[str]:
    """Return the text under the pointer of each point: values with intervals, and gains."""
    texts = []
    for row, point in enumerate(front.points):
        mark = ", recommended" if front.recommended[row] else ""
        mark += f", {counted(int(front.lost[row]), 'failed flight')}" if front.lost[row] else ""
        lines = [f"<b>{escape(front.contender)} {escape(point)}</b>{mark}"]
        for i, label in enumerate(fronts.objectives):
            middle, low, high = (float(part[row, i]) for part in (front.values, front.low, front.high))
            value, ends = estimate(middle, low, high)
            lines.append(
                escape(f"{compared_label(compared, label)}: {value} {ends} {plain(compared.quantity[label].unit)}")
            )
        gains = joined([Gain(name, value, "") for name, value in front.gains[row].items()])
        lines += [escape(f"{gain.address} = {significant(gain.value)}") for gain in gains]
        texts.append("<br>".join(lines))
    return texts


def _span(compared: ComparedFolder, objective: int) -> AxisRange:
    """Return the part of an objective's axis that holds all fronts with their intervals."""
    return span_of(
        [part[:, objective] for front in compared.front_points for part in (front.values, front.low, front.high)],
        LOG_FACTOR,
    )


def _pair(compared: ComparedFolder, fronts: FrontsPart, i: int, j: int) -> Panel:
    marks = [mark for front in compared.front_points for mark in _front(compared, fronts, front, (i, j))]
    x, y = (
        value_axis(
            compared_label(compared, fronts.objectives[k]),
            compared.quantity[fronts.objectives[k]].unit,
            _span(compared, k),
        )
        for k in (i, j)
    )
    title = f"{compared_label(compared, fronts.objectives[j])} over {compared_label(compared, fronts.objectives[i])}"
    return Panel(f"front-{i}-{j}", title, x, y, marks, form="pair")


def _front(compared: ComparedFolder, fronts: FrontsPart, front: ContenderFront, pair: Sequence[int]) -> list[Mark]:
    look, show = looks_of(compared)[front.contender], {"layer": compared.layer(front.contender)}
    x, y = (front.values[:, k] for k in pair)
    marks: list[Mark] = []
    if len(fronts.objectives) == 2 and len(x) > 1:
        order = np.argsort(x, kind="stable")
        marks.append(Line(look=look._replace(width=1.4), x=x[order], y=y[order], steps=True, show=show))
    return [*marks, *_points(compared, fronts, front, x, y, look, [(front.low[:, k], front.high[:, k]) for k in pair])]


def _points(
    compared: ComparedFolder,
    fronts: FrontsPart,
    front: ContenderFront,
    x: np.ndarray,
    y: np.ndarray,
    look: Look,
    ends: Sequence[tuple[np.ndarray, np.ndarray]],
) -> list[Mark]:
    show, chosen = {"layer": compared.layer(front.contender)}, front.recommended
    hover = hover_texts(compared, fronts, front)
    across, up = ends[0], ends[1] if len(ends) > 1 else None
    points = Points(name=front.contender, look=look, x=x, y=y, x_ends=across, y_ends=up, hover=hover, show=show)
    place = PLACES[compared.index[front.contender] % len(PLACES)]
    texts = [front.contender] * int(chosen.sum())
    ring = Points(look=RING, x=x[chosen], y=y[chosen], texts=texts, place=place, show=show)
    return [points, *lost_points(x, y, front.lost, show), *([ring] if chosen.any() else [])]


def _ranking(compared: ComparedFolder, fronts: FrontsPart) -> Panel:
    """One objective: a row of points for each contender, the best to the left."""
    names, marks = [front.contender for front in compared.front_points], []
    for row, front in enumerate(compared.front_points):
        height, ends = np.full(len(front.points), -float(row)), [(front.low[:, 0], front.high[:, 0])]
        marks += _points(compared, fronts, front, front.values[:, 0], height, looks_of(compared)[front.contender], ends)
    label = fronts.objectives[0]
    x = value_axis(compared_label(compared, label), compared.quantity[label].unit, _span(compared, 0))
    return Panel("front-ranking", label, x, row_axis(names), marks, form="pair", rows=True)
