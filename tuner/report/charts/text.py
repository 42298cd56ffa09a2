"""Charts of points for the terminal, drawn with characters; readable on any terminal, in a pipe and without colour."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tuner.documents.tuning import TuningFolder
from tuner.report.charts.chart import Array, Panel, Points
from tuner.report.charts.front import front_panels
from tuner.report.charts.look import DEFAULT, FRONT, LOST, SEARCHED, TUNED

LETTERS = {SEARCHED: ".", FRONT: "o", LOST: "x", DEFAULT: "D", TUNED: "@"}
"""The letters of the looks that a terminal shows; points with other looks are left out."""
GAP = "   "
MARGIN = 0.04
"""Share of the range of the points that is left free on either side."""


class TextLayer(NamedTuple):
    """Points (n, 2) that share a mark of one letter; later layers lie on top.

    cut: they do not widen the axes. edge: those outside the axes stand at the edge, instead of being left out.
    """

    mark: str
    name: str
    points: Array
    cut: bool = False
    edge: bool = False


def failed_flights_text(lost: np.ndarray) -> str:
    """Return the legend of points that lost flights; lost (points,): how many each lost."""
    return f"failed flights when held out ({int((lost > 0).sum())} points, {int(lost.sum())} flights; at the edge if beyond it)"


def front_lines(results: TuningFolder, width: int, height: int) -> list[str]:
    """Return the lines; values are in the units that reports show, angles in degrees."""
    names = {
        ".": "tried, as the search saw it",
        "o": "front",
        "x": failed_flights_text(results.held_out_front.lost),
        "@": results.called,
    }
    return to_text(front_panels(results)[0], names, width, height)


def to_text(panel: Panel, names: dict[str, str], width: int, height: int) -> list[str]:
    """Return the points of a panel as lines; names: what the legend calls each letter."""
    layers = [
        TextLayer(
            letter,
            names.get(letter, mark.name),
            np.stack([mark.x, mark.y], axis=1),
            mark.look in (SEARCHED, LOST),
            mark.look == LOST,
        )
        for look, letter in LETTERS.items()
        for mark in panel.marks
        if isinstance(mark, Points) and mark.look == look
    ]
    return scatter(layers, (panel.x.title, panel.y.title), width, height)


def scatter(layers: Sequence[TextLayer], labels: tuple[str, str], width: int, height: int) -> list[str]:
    """Return lines of at most `width` characters: label of y, `height` lines of the plot, axis, label of x, legend.

    Layers that are cut do not widen the axes; at least one point must stand in a layer that is not.
    """
    uncut = np.concatenate([layer.points for layer in layers if not layer.cut], axis=0)
    low, high = axes(uncut)
    ends = [f"{number:.3g}" for number in (low[1], high[1])]
    indent = max(map(len, ends))
    cells = [[" "] * (width - indent - 2) for _ in range(height)]
    for layer in layers:
        points = np.clip(layer.points, low, high) if layer.edge else layer.points
        for column, row in places(points, low, high, len(cells[0]), height):
            cells[row][column] = layer.mark
    lines = [labels[1]]
    for row, line in enumerate(cells):
        end = ends[1] if row == 0 else ends[0] if row == height - 1 else ""
        lines.append(f"{end:>{indent}} |{''.join(line)}".rstrip())
    lines.append(f"{'':{indent}} +{'-' * len(cells[0])}")
    left, right = f"{low[0]:.3g}", f"{high[0]:.3g}"
    lines.append(f"{'':{indent + 2}}{left}{right:>{len(cells[0]) - len(left)}}")
    lines.append(f"{'':{indent + 2}}{labels[0]:^{len(cells[0])}}".rstrip())
    return [*lines, *legend([layer for layer in layers if len(layer.points)], width)]


def legend(layers: Sequence[TextLayer], width: int) -> list[str]:
    """Return marks and names in lines of at most `width` characters."""
    lines: list[str] = []
    for layer in layers:
        entry = f"{layer.mark} {layer.name}"
        if lines and len(lines[-1]) + len(GAP) + len(entry) <= width:
            lines[-1] += GAP + entry
        else:
            lines.append(entry)
    return lines


def axes(points: Array) -> tuple[Array, Array]:
    """Return both ends (2,) of the axes around points (n, 2)."""
    low, high = points.min(axis=0), points.max(axis=0)
    # An axis without extent gets a tenth of its value, or 1 around 0.
    span = np.where(high > low, high - low, np.where(high != 0.0, 0.1 * np.abs(high), 1.0))
    return low - MARGIN * span, high + MARGIN * span


def places(points: Array, low: Array, high: Array, columns: int, rows: int) -> list[tuple[int, int]]:
    """Return column and row, from the top, of the points (n, 2) that are within the axes."""
    share = (points - low) / (high - low)
    inside = share[np.all((share >= 0.0) & (share <= 1.0), axis=1)]
    across = np.minimum((inside[:, 0] * columns).astype(int), columns - 1)
    down = rows - 1 - np.minimum((inside[:, 1] * rows).astype(int), rows - 1)
    return list(zip(across.tolist(), down.tolist(), strict=True))


def place_bar(share: float, default: float, length: int) -> str:
    """Return a range as a bar of characters with the default (D) and the value (@) in it; shares 0 to 1 of the range."""
    cells = ["-"] * length
    for at, mark in ((default, "D"), (share, "@")):
        cells[min(int(min(max(at, 0.0), 1.0) * length), length - 1)] = mark
    return f"|{''.join(cells)}|"
