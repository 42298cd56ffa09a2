"""Charts for paper, drawn by matplotlib: size, type and marks of every figure, and how figures are saved as PNG and PDF.

The inks stay apart for colour-blind eyes and in grey; shapes and dashes say the same.
"""

from collections.abc import Sequence
from io import BytesIO
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import FixedLocator, NullLocator

from tuner.report.charts.chart import Array, Axis, Band, Bars, Disc, Line, Mark, Panel, Points, Rule, Words
from tuner.report.charts.look import INKS, Look
from tuner.store.folder import put

# Marks at the edge of an axis for what lies beyond it: to the left, right, below, above.
EDGES = {(-1, 0): "<", (1, 0): ">", (0, -1): "v", (0, 1): "^"}
# Text width of a two-column page [in], and resolution of the PNG [dots/in].
WIDTH, DPI = 7.1, 200
# Room that an entry of a legend takes: the mark with its gaps, a letter, and a row [in].
LEGEND_MARK, LEGEND_LETTER, LEGEND_ROW = 0.55, 0.05, 0.16
STYLE: dict[Any, Any] = {
    "font.size": 8,
    "axes.labelsize": 8,
    "axes.titlesize": 8,
    "legend.fontsize": 7.5,
    "legend.frameon": False,
    "axes.linewidth": 0.6,
    "axes.edgecolor": INKS["ink"],
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e4e7ea",
    "grid.linewidth": 0.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.linewidth": 1.2,
    # Text stays text in the PDF (TrueType), as journals ask.
    "pdf.fonttype": 42,
}


def style() -> Any:
    """Return the context in which figures are drawn and saved."""
    return rc_context(STYLE)


def grid(count: int, columns: int, height: float, width: float = WIDTH) -> tuple[Figure, list[Axes]]:
    """Return a figure with so many axes in reading order; height of a row and width of the figure [in]."""
    rows = ceil(count / columns)
    figure = Figure(figsize=(width, height * rows), layout="constrained")
    FigureCanvasAgg(figure)
    axes = list(figure.subplots(rows, columns, squeeze=False).flat)
    for unused in axes[count:]:
        unused.set_visible(False)
    return figure, axes[:count]


def legend_above(figure: Figure, *axes: Axes) -> None:
    """Put one legend for the whole figure above it, each name once, in as many columns as fit."""
    found: dict[str, Any] = {}
    for ax in axes:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            found.setdefault(str(label), handle)
    if not found:
        return
    widths = [LEGEND_MARK + LEGEND_LETTER * len(label) for label in found]
    width, height = figure.get_size_inches()
    columns = len(found) if sum(widths) <= width else max(int(width / max(widths)), 1)
    figure.set_size_inches(width, height + LEGEND_ROW * (ceil(len(found) / columns) - 1))
    figure.legend(found.values(), found.keys(), loc="outside upper center", ncols=columns)


def figure_of(
    panels: Sequence[Panel], columns: int, height: float, width: float = WIDTH, legend: bool = True
) -> Figure:
    """Return a figure of panels in reading order; height of a row and width of the figure [in]."""
    figure, axes = grid(len(panels), columns, height, width)
    for ax, panel in zip(axes, panels, strict=True):
        draw(ax, panel)
        mark_edges(ax, panel)
    if legend:
        legend_above(figure, *axes)
    return figure


def draw(ax: Axes, panel: Panel) -> None:
    """Draw a panel: its marks, and its axes around them."""
    for mark in panel.marks:
        draw_mark(ax, mark, panel)
    _show_axis(ax, "x", panel.x)
    _show_axis(ax, "y", panel.y)
    if panel.rows:
        ax.grid(visible=False, axis="y")
    if panel.square:
        ax.set_aspect("equal")


def draw_mark(ax: Axes, mark: Mark, panel: Panel | None = None) -> None:
    """Draw one mark; panel: whose edges hold points that lie beyond them."""
    label = mark.name or "_"
    match mark:
        case Points():
            _points(ax, mark, panel)
        case Line():
            _line(ax, mark, label)
        case Band():
            ax.fill_between(mark.x, mark.low, mark.high, color=mark.look.ink, alpha=mark.look.opacity, linewidth=0)
        case Bars():
            _bars(ax, mark, label)
        case Rule():
            draw_rule = ax.axvline if mark.axis == "x" else ax.axhline
            draw_rule(mark.value, label=label, zorder=1, **stroke(mark.look))
        case Disc():
            face = mark.look.ink if mark.fill == "filled" else "none"
            hatch = "////" if mark.fill == "hatched" else None
            edge: dict[str, Any] = {"edgecolor": mark.look.ink, "linewidth": 0.8, "linestyle": mark.look.linestyle}
            ax.add_patch(
                Circle(
                    (mark.x, mark.y),
                    mark.radius,
                    facecolor=face,
                    hatch=hatch,
                    alpha=mark.look.opacity,
                    label=label,
                    **edge,
                )
            )
        case Words():
            place: dict[str, Any] = {"transform": ax.get_yaxis_transform(), "va": "center"} if mark.right else {}
            ax.text(mark.x, mark.y, mark.text, fontsize=6.5, color=mark.look.ink, **place)


def stroke(look: Look) -> dict[str, Any]:
    """Return the line of a look; its widths are in pixels of the page."""
    return {"color": look.ink, "linestyle": look.linestyle, "linewidth": 0.65 * look.width}


def _points(ax: Axes, mark: Points, panel: Panel | None) -> None:
    look, sides = mark.look, np.zeros((len(mark.x), 2), dtype=int)
    if mark.edge and panel is not None:
        sides = np.stack([_side(mark.x, panel.x), _side(mark.y, panel.y)], axis=1)
    crossed = look.symbol == "x-thin" and mark.edge
    rows = np.ones(len(mark.x), dtype=bool) if crossed else np.logical_not(sides.any(axis=1)).reshape(-1)
    x, y = (
        (mark.x, mark.y)
        if panel is None
        else (_held(mark.x, panel.x), _held(mark.y, panel.y))
        if mark.edge
        else (mark.x, mark.y)
    )
    face = "white" if look.hollow and look.size < 15 else "none" if look.hollow else look.ink
    style: dict[str, Any] = {
        "color": look.ink,
        "markerfacecolor": face,
        "markersize": 0.45 * look.size,
        "label": mark.name or "_",
    }
    order = 6 if crossed else 4 if look.size >= 10 else 3
    if not rows.any():
        return
    if mark.x_ends or mark.y_ends:
        bars = {"xerr": _reach(mark.x, mark.x_ends, rows), "yerr": _reach(mark.y, mark.y_ends, rows)}
        ax.errorbar(x[rows], y[rows], **bars, fmt=look.marker, elinewidth=0.6, zorder=order, **style)
    else:
        ax.plot(x[rows], y[rows], look.marker, clip_on=not mark.edge, zorder=order, **style)


def _reach(values: Array, ends: tuple[Array, Array] | None, rows: Array) -> Array | None:
    """Return how far intervals reach below and above their values, (2, rows)."""
    return None if ends is None else np.maximum(np.stack([values - ends[0], ends[1] - values])[:, rows], 0.0)


def _side(values: Array, axis: Axis) -> Array:
    """Return on which side of an axis values lie: -1 below, 0 within, 1 above."""
    if axis.ends is None:
        return np.zeros(len(values), dtype=int)
    return (values > axis.ends[1]).astype(int) - (values < axis.ends[0]).astype(int)


def _held(values: Array, axis: Axis) -> Array:
    return values if axis.ends is None else np.clip(values, *axis.ends)


def _line(ax: Axes, mark: Line, label: str) -> None:
    more = {"marker": mark.look.marker, "markersize": 3} if mark.marked else {}
    draw_line = ax.step if mark.steps else ax.plot
    where = {"where": "post"} if mark.steps else {}
    draw_line(
        mark.x, mark.y, label=label, zorder=2 if mark.name == "reference" else 3, **stroke(mark.look), **where, **more
    )


def _bars(ax: Axes, mark: Bars, label: str) -> None:
    if not mark.across:
        ax.bar(mark.x, mark.y, width=mark.width, color=mark.look.ink, label=label)
        return
    ax.barh(mark.y, mark.x, height=mark.width, color=mark.look.ink, label=label)
    if mark.ends:
        # A percentile interval may leave its estimate out by a hair; a whisker has no negative length.
        whiskers = _reach(mark.x, mark.ends, np.ones(len(mark.x), dtype=bool))
        ax.errorbar(mark.x, mark.y, xerr=whiskers, fmt="none", ecolor=INKS["ink"], elinewidth=0.7, capsize=1.5)


def mark_edges(ax: Axes, panel: Panel) -> None:
    """Mark the points that lie beyond the axes at the edge; one beyond both is marked at the corner by its first."""
    places = [
        (mark.x, mark.y)
        for mark in panel.marks
        if isinstance(mark, Points) and mark.edge and mark.look.symbol != "x-thin"
    ]
    if not places:
        return
    x, y = (np.concatenate(parts) for parts in zip(*places, strict=True))
    sides = np.stack([_side(x, panel.x), _side(y, panel.y)], axis=1)
    label = f"beyond the axes ({int(sides.any(axis=1).sum())})"
    for (across, up), marker in EDGES.items():
        rows = (sides[:, 0] == across) & ((sides[:, 1] == up) | bool(across))
        if rows.any():
            shown = _held(x[rows], panel.x), _held(y[rows], panel.y)
            ax.plot(*shown, marker, markersize=5, color=INKS["faint"], clip_on=False, zorder=5, label=label)
            label = "_"


def _show_axis(ax: Axes, name: str, axis: Axis) -> None:
    line = ax.xaxis if name == "x" else ax.yaxis
    if axis.log:
        ax.set(**{f"{name}scale": "log"})
    if axis.ticks:
        line.set_major_locator(FixedLocator([value for value, _ in axis.ticks]))
        line.set_minor_locator(NullLocator())
        line.set_ticklabels([text for _, text in axis.ticks])
    elif axis.step and not axis.log and axis.ends:
        line.set_major_locator(FixedLocator(np.arange(axis.ends[0], axis.ends[1] + 1e-9, axis.step).tolist()))
    if axis.ends:
        ax.set(**{f"{name}lim": axis.ends})
    line.set_label_text(axis.title)


def save(figure: Figure, folder: Path, name: str) -> list[Path]:
    """Write NAME.png and NAME.pdf into a results folder, each whole or not at all; return both paths."""
    return [put(folder, name + ending, content) for ending, content in printed(figure).items()]


def printed(figure: Figure) -> dict[str, bytes]:
    """Return a figure as ".png" and ".pdf", without a date so that the same results give the same bytes.

    Printed by the canvases themselves, because `Figure.savefig` draws everything a second time for its bounding box.
    What was laid out for the first file stands for the second.
    """
    png, pdf = BytesIO(), BytesIO()
    figure.set_dpi(DPI)
    FigureCanvasAgg(figure).print_png(png)
    figure.set_layout_engine("none")
    FigureCanvasPdf(figure).print_pdf(pdf, metadata={"CreationDate": None})
    return {".png": png.getvalue(), ".pdf": pdf.getvalue()}
