"""The held-out front for a paper: error bars, default and tuned marked, search candidates in grey."""

from itertools import combinations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tuner.report.figure_style import COLOURS, MARKERS, WIDTH, grid, legend_above
from tuner.report.front_ranges import Range, shown_range
from tuner.report.results import Results
from tuner.report.units import bracketed

# Two panels a row for few pairs, three for more; pairs beyond these do not fit on a page.
MOST_PAIRS = 12
LABELS = {"front": "front, held-out", "default": "default", "tuned": "tuned"}


def front_figure(results: Results) -> Figure:
    """Return a figure with a panel for each pair of objectives; for one objective, the points in order."""
    count = len(results.objectives)
    ranges = [shown_range(results.front, i) for i in range(count)]
    if count == 1:
        figure, axes = grid(1, 1, 0.9 + 0.17 * len(results.front.points), 0.62 * WIDTH)
        _ranking(axes[0], results, ranges[0])
    else:
        pairs = list(combinations(range(count), 2))[:MOST_PAIRS]
        columns = min(len(pairs), 3)
        wide = WIDTH if columns > 1 else 0.62 * WIDTH
        figure, axes = grid(len(pairs), columns, 3.2 if columns == 1 else 2.4, wide)
        for ax, (i, j) in zip(axes, pairs, strict=True):
            _pair(ax, results, ranges, i, j)
    legend_above(figure, axes[0])
    return figure


def _pair(ax: Axes, results: Results, ranges: list[Range], i: int, j: int) -> None:
    front, tried = results.front, results.candidates
    kept = tried.feasible
    ax.plot(tried.values[kept, i], tried.values[kept, j], ".", markersize=2, color=COLOURS["grey"], label="searched")
    for kind, rows in _kinds(results).items():
        value = front.held_out[rows]
        bars = _bars(results, rows)
        _mark(ax, kind, value[:, i], value[:, j], bars[:, :, i], bars[:, :, j])
    _show(ax, "x", results, ranges[i], i)
    _show(ax, "y", results, ranges[j], j)


def _ranking(ax: Axes, results: Results, shown: Range) -> None:
    front = results.front
    order = np.argsort(-front.held_out[:, 0], kind="stable")
    height = np.empty(len(order))
    height[order] = np.arange(len(order))
    rest = [k for k, role in enumerate(front.roles) if role == "" and not front.non_dominated[k]]
    for kind, rows in {"finalist": rest, **_kinds(results)}.items():
        _mark(ax, kind, front.held_out[rows, 0], height[rows], _bars(results, rows)[:, :, 0], None)
    ax.set_yticks(height, front.points, fontsize=6.5)
    ax.grid(visible=False, axis="y")
    _show(ax, "x", results, shown, 0)


def _kinds(results: Results) -> dict[str, list[int]]:
    front = results.front
    best = [k for k, role in enumerate(front.roles) if role == "" and front.non_dominated[k]]
    return {"front": best, "default": front.of("default"), "tuned": front.of("tuned")}


def _bars(results: Results, rows: list[int]) -> np.ndarray:
    """Return how far the intervals reach below and above the values, (2, rows, objectives)."""
    front = results.front
    value = front.held_out[rows]
    return np.clip(np.stack([value - front.low[rows], front.high[rows] - value], axis=0), 0.0, None)


def _mark(
    ax: Axes, kind: str, x: np.ndarray, y: np.ndarray, across: np.ndarray, along: np.ndarray | None
) -> None:  # fmt: skip
    if len(x) == 0:
        return
    colour = COLOURS.get(kind, COLOURS["grey"])
    face = "white" if kind in ("default", "finalist") else colour
    ax.errorbar(
        x, y, xerr=across, yerr=along, fmt=MARKERS.get(kind, "o"), color=colour, markerfacecolor=face, elinewidth=0.6,
        markersize=6 if kind in ("default", "tuned") else 3.5, label=LABELS.get(kind, "finalist"),
        zorder=4 if kind in ("default", "tuned") else 3,
    )  # fmt: skip


def _show(ax: Axes, name: str, results: Results, shown: Range, objective: int) -> None:
    quantity = results.objectives[objective]
    ax.set(
        **{
            f"{name}scale": "log" if shown.log else "linear",
            f"{name}lim": (shown.low, shown.high),
            f"{name}label": bracketed(quantity.label, quantity.unit),
        }
    )
