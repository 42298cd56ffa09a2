"""The trade-off of a tuning run: what the search tried, the finalists on held-out flights, default and tuned."""

from itertools import combinations

import numpy as np

from plant.ties import increasing_order
from tuner.documents.tuning import TuningFolder
from tuner.documents.tuning_tables import HeldOutFront
from tuner.report.charts.chart import Axis, AxisRange, Mark, Panel, Points, row_axis, span_of, value_axis
from tuner.report.charts.look import DEFAULT, FINALIST, FRONT, INFEASIBLE, LOST, SEARCHED, START, TUNED, Look
from tuner.report.labels import named
from tuner.text.sentences import counted

# Layers of points from back to front, with what they are called and how they look in every renderer.
LAYERS: dict[str, tuple[str, Look]] = {
    "infeasible": ("limit violated, search values", INFEASIBLE),
    "searched": ("other candidates, search values", SEARCHED),
    "finalist": ("off the front when held out", FINALIST),
    "front": ("front, held-out", FRONT),
    "start": ("design start, search values", START),
    "default": ("default", DEFAULT),
    "tuned": ("tuned", TUNED),
}
# Where the shown values span more than this factor, a linear axis would press most points into a corner.
LOG_FACTOR = 20.0
# Pairs beyond these do not fit on a page.
MAX_PAIRS = 12


def front_panels(results: TuningFolder) -> list[Panel]:
    """Return a panel for each pair of objectives, or one with a row a point where there is one objective."""
    count = len(results.objectives)
    if count == 1:
        return [_ranking(results)]
    return [_pair(results, i, j) for i, j in list(combinations(range(count), 2))[:MAX_PAIRS]]


def shown_range(front: HeldOutFront, objective: int) -> AxisRange:
    """Return the part of an objective's axis that is shown: default, tuned and the held-out front, with intervals.

    Search candidates, and finalists that failed when held out, may lie decades away (a failed flight costs more than any
    completed one), so they do not count.
    """
    rows = shown_rows(front)
    return span_of([part[rows, objective] for part in (front.held_out, front.low, front.high)], LOG_FACTOR, 0.07)


def shown_rows(front: HeldOutFront) -> np.ndarray:
    """Return the mask of the points that axes hold: default, tuned and the held-out front."""
    return front.non_dominated | np.array([role != "" for role in front.roles])


def layer_of(front: HeldOutFront, row: int) -> str:
    """Return the layer of a finalist."""
    return front.roles[row] or ("front" if front.non_dominated[row] else "finalist")


def objective_axis(results: TuningFolder, objective: int) -> Axis:
    """Return the axis of an objective."""
    entry, shown = results.objectives[objective], shown_range(results.held_out_front, objective)
    return value_axis(named(results, entry, short=True), entry.unit, shown)


def _pair(results: TuningFolder, i: int, j: int) -> Panel:
    front, tried = results.held_out_front, results.evaluated
    feasible = tried.feasible
    marks: list[Mark] = [
        Points(name="searched", look=SEARCHED, x=tried.values[feasible, i], y=tried.values[feasible, j])
    ]
    marks += _finalists(results, front.held_out[:, i], front.held_out[:, j], i, j)
    return Panel(f"front-{i}-{j}", "", objective_axis(results, i), objective_axis(results, j), marks, form="pair")


def _ranking(results: TuningFolder) -> Panel:
    front = results.held_out_front
    order = increasing_order(front.held_out[:, 0])
    height = np.empty(len(order))
    height[order] = -np.arange(len(order))
    marks = _finalists(results, front.held_out[:, 0], height, 0, None)
    rows = row_axis([front.points[row] for row in order])
    return Panel("front-ranking", "", objective_axis(results, 0), rows, marks, form="pair", rows=True)


def _finalists(results: TuningFolder, x: np.ndarray, y: np.ndarray, i: int, j: int | None) -> list[Mark]:
    front = results.held_out_front
    layers = np.array([layer_of(front, row) for row in range(len(front.points))])
    marks: list[Mark] = []
    for layer in ("finalist", "front", "default", "tuned"):
        rows = np.flatnonzero(layers == layer)
        if len(rows):
            name = results.shown_as if layer == "tuned" else LAYERS[layer][0]
            ends = [None if k is None else (front.low[rows, k], front.high[rows, k]) for k in (i, j)]
            marks.append(
                Points(
                    name=name,
                    look=LAYERS[layer][1],
                    x=x[rows],
                    y=y[rows],
                    x_ends=ends[0],
                    y_ends=ends[1],
                    labels=[front.points[row] for row in rows],
                    edge=True,
                )
            )
    return [*marks, *lost_points(x, y, front.lost)]


def lost_points(x: np.ndarray, y: np.ndarray, lost: np.ndarray, show: dict[str, str] | None = None) -> list[Mark]:
    """Return crosses over the points (n,) that lost flights; lost (n,): how many each lost."""
    rows = lost > 0
    if not rows.any():
        return []
    name = f"{counted(int(lost.sum()), 'failed flight')} ({counted(int(rows.sum()), 'point')})"
    return [Points(name=name, look=LOST, x=x[rows], y=y[rows], edge=True, show=show or {})]
