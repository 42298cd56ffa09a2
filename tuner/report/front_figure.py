"""The held-out front for a paper: error bars, default and tuned marked, search candidates in grey."""

from itertools import combinations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tuner.documents.results import Results
from tuner.report.figure_style import COLOURS, MARKERS, WIDTH, grid, legend_above
from tuner.report.front_ranges import Range, shown_range
from tuner.report.prose import counted
from tuner.text.units import bracketed

# Two panels a row for few pairs, three for more; pairs beyond these do not fit on a page.
MOST_PAIRS = 12
LABELS = {"front": "front, held-out", "default": "default", "finalist": "off the front when held out"}
# Marks at the edge of an axis for what lies beyond it: to the left, right, below, above.
EDGES = {(-1, 0): "<", (1, 0): ">", (0, -1): "v", (0, 1): "^"}


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
    places, shown = front.held_out[:, [i, j]], [ranges[i], ranges[j]]
    for kind, every in _kinds(results).items():
        rows = [row for row in every if not beyond(places[[row]], shown).any()]
        bars = _bars(results, rows)
        _mark(ax, kind, _label(kind, results), places[rows, 0], places[rows, 1], bars[:, :, i], bars[:, :, j])
    _mark_edges(ax, places, shown)
    mark_lost(ax, held(places[front.lost > 0], shown), front.lost)
    _show(ax, "x", results, ranges[i], i)
    _show(ax, "y", results, ranges[j], j)


def _ranking(ax: Axes, results: Results, shown: Range) -> None:
    front = results.front
    order = np.argsort(-front.held_out[:, 0], kind="stable")
    height = np.empty(len(order))
    height[order] = np.arange(len(order))
    for kind, every in _kinds(results).items():
        rows = [row for row in every if not beyond(front.held_out[[row], :1], [shown]).any()]
        across = _bars(results, rows)[:, :, 0]
        _mark(ax, kind, _label(kind, results), front.held_out[rows, 0], height[rows], across, None)
    places, ranges = np.stack([front.held_out[:, 0], height], axis=1), [shown, Range(-1.0, len(order), False)]
    _mark_edges(ax, places, ranges)
    mark_lost(ax, held(places[front.lost > 0], ranges), front.lost)
    ax.set_yticks(height, front.points, fontsize=6.5)
    ax.grid(visible=False, axis="y")
    _show(ax, "x", results, shown, 0)


def _kinds(results: Results) -> dict[str, list[int]]:
    front = results.front
    plain = [k for k, role in enumerate(front.roles) if role == ""]
    best, rest = ([k for k in plain if bool(front.non_dominated[k]) is wanted] for wanted in (True, False))
    return {"finalist": rest, "front": best, "default": front.of("default"), "tuned": front.of("tuned")}


def beyond(places: np.ndarray, ranges: list[Range]) -> np.ndarray:
    """Return on which side of the axes places (n, axes) lie: -1 below, 0 within, 1 above (n, axes)."""
    low, high = (np.array([getattr(shown, end) for shown in ranges]) for end in ("low", "high"))
    return (places > high).astype(int) - (places < low).astype(int)


def held(places: np.ndarray, ranges: list[Range]) -> np.ndarray:
    """Return places (n, axes), moved to the edge where they lie beyond the axes."""
    return np.clip(places, [shown.low for shown in ranges], [shown.high for shown in ranges])


def _mark_edges(ax: Axes, places: np.ndarray, ranges: list[Range]) -> None:
    """Mark places (n, 2) beyond the axes at the edge; one beyond both is marked at the corner by its first."""
    sides, shown = beyond(places, ranges), held(places, ranges)
    count = int(sides.any(axis=1).sum())
    label = f"beyond the axes ({count})"
    for (x, y), marker in EDGES.items():
        rows = (sides[:, 0] == x) & ((sides[:, 1] == y) | bool(x))
        if rows.any():
            ax.plot(*shown[rows].T, marker, markersize=5, color=COLOURS["grey"], clip_on=False, zorder=5, label=label)
            label = "_"


def mark_lost(ax: Axes, places: np.ndarray, lost: np.ndarray) -> None:
    """Cross out the places (n, 2) of points that lost flights; lost (points,): how many each point lost."""
    if len(places):
        label = f"lost {counted(int(lost.sum()), 'flight')} ({counted(len(places), 'point')})"
        ax.plot(*places.T, "x", markersize=7, color=COLOURS["bad"], clip_on=False, zorder=6, label=label)


def _label(kind: str, results: Results) -> str:
    return results.shown_as if kind == "tuned" else LABELS.get(kind, "finalist")


def _bars(results: Results, rows: list[int]) -> np.ndarray:
    """Return how far the intervals reach below and above the values, (2, rows, objectives)."""
    front = results.front
    value = front.held_out[rows]
    return np.clip(np.stack([value - front.low[rows], front.high[rows] - value], axis=0), 0.0, None)


def _mark(
    ax: Axes, kind: str, label: str, x: np.ndarray, y: np.ndarray, across: np.ndarray, along: np.ndarray | None
) -> None:  # fmt: skip
    if len(x) == 0:
        return
    colour = COLOURS.get(kind, COLOURS["grey"])
    face = "white" if kind in ("default", "finalist") else colour
    ax.errorbar(
        x, y, xerr=across, yerr=along, fmt=MARKERS.get(kind, "o"), color=colour, markerfacecolor=face, elinewidth=0.6,
        markersize=6 if kind in ("default", "tuned") else 3.5, label=label,
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
