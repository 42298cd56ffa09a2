"""The fronts of all contenders for a paper: a panel for each pair of objectives, with error bars, recommended points ringed."""

from itertools import combinations
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tuner.documents.contest import Contest, Front, Fronts
from tuner.report.contest.figure_axes import show_span
from tuner.report.contest.front_charts import objective_span, reach, stairs
from tuner.report.figure_style import COLOURS, WIDTH, grid, legend_above
from tuner.report.front_figure import mark_lost
from tuner.text.units import bracketed

# Pairs beyond these do not fit on a page.
MOST_PAIRS = 12
RING: dict[str, Any] = {
    "markersize": 9,
    "markerfacecolor": "none",
    "markeredgecolor": COLOURS["ink"],
    "linestyle": "none",
}


def fronts_figure(contest: Contest) -> Figure | None:
    """Return the figure, for one objective the points in rows; None where nothing was tuned."""
    fronts = contest.fronts
    if fronts is None or not fronts.fronts:
        return None
    count = len(fronts.objectives)
    if count == 1:
        figure, axes = grid(1, 1, 0.9 + 0.3 * len(fronts.fronts), 0.75 * WIDTH)
        _ranking(contest, fronts, axes[0])
        return figure
    pairs = list(combinations(range(count), 2))[:MOST_PAIRS]
    single = len(pairs) == 1
    figure, axes = grid(len(pairs), min(len(pairs), 3), 3.6 if single else 2.5, 0.85 * WIDTH if single else WIDTH)
    for ax, (i, j) in zip(axes, pairs, strict=True):
        for front in fronts.fronts:
            _front(contest, ax, front, i, j, joined=single)
        _axis(contest, fronts, ax, "x", i)
        _axis(contest, fronts, ax, "y", j)
    for ax, (i, j) in zip(axes, pairs, strict=True):
        crossed = np.concatenate([front.values[front.lost > 0][:, [i, j]] for front in fronts.fronts])
        mark_lost(ax, crossed, np.concatenate([front.lost for front in fronts.fronts]))
    axes[0].plot([], [], "o", **RING, label="recommended")
    legend_above(figure, axes[0])
    return figure


def _front(contest: Contest, ax: Axes, front: Front, i: int, j: int, joined: bool) -> None:
    look, x, y = contest.look[front.contender], front.values[:, i], front.values[:, j]
    if joined and len(x) > 1:
        ax.step(*stairs(x, y), where="post", color=look.ink, linestyle=look.linestyle, linewidth=0.9, zorder=2)
    ax.errorbar(
        x, y, xerr=reach(front, i), yerr=reach(front, j), fmt=look.marker, color=look.ink, markersize=4, elinewidth=0.5,
        markerfacecolor="white" if look.hollow else look.ink, label=front.contender, zorder=3,
    )  # fmt: skip
    _ring(ax, x[front.recommended], y[front.recommended])


def _ring(ax: Axes, x: np.ndarray, y: np.ndarray) -> None:
    ax.plot(x, y, "o", **RING, zorder=4)


def _ranking(contest: Contest, fronts: Fronts, ax: Axes) -> None:
    names = [front.contender for front in fronts.fronts]
    for row, front in enumerate(fronts.fronts):
        look, height = contest.look[front.contender], np.full(len(front.points), -float(row))
        face = "white" if look.hollow else look.ink
        bars = {"xerr": reach(front, 0), "fmt": look.marker, "color": look.ink, "markerfacecolor": face}
        ax.errorbar(front.values[:, 0], height, **bars, markersize=4, elinewidth=0.6)
        _ring(ax, front.values[front.recommended, 0], height[front.recommended])
        mark_lost(ax, np.stack([front.values[front.lost > 0, 0], height[front.lost > 0]], axis=1), front.lost)
    ax.set_yticks([-float(row) for row in range(len(names))], names)
    ax.set_ylim(0.6 - len(names), 0.6)
    ax.grid(visible=False, axis="y")
    _axis(contest, fronts, ax, "x", 0)


def _axis(contest: Contest, fronts: Fronts, ax: Axes, name: str, objective: int) -> None:
    label = fronts.objectives[objective]
    show_span(ax, name, objective_span(fronts, objective))
    ax.set(**{f"{name}label": bracketed(label, contest.quantity[label].unit)})
