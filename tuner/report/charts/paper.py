"""Charts for paper, the only module that knows matplotlib: size, type and marks of every figure, and how figures are saved.

The inks stay apart for colour-blind eyes and in grey; shapes and dashes say the same.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from io import BytesIO
from math import ceil
from typing import Any, TypedDict

import numpy as np
from fontTools import subset
from matplotlib import rc_context, rcParamsDefault
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure as MatplotlibFigure
from matplotlib.patches import Circle
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from tuner.report.charts.chart import FAR, Array, Axis, Band, Bars, Disc, Line, Mark, Panel, Points, Region, Rule, Words
from tuner.report.charts.look import INKS, REFERENCE, Look
from tuner.report.charts.sheet import WIDTH, FigureSpec

# Marks at the edge of an axis for what lies beyond it: to the left, right, below, above.
EDGES = {(-1, 0): "<", (1, 0): ">", (0, -1): "v", (0, 1): "^"}
# Resolution of the PNG [dots/in].
DPI = 200
# Room that an entry of a legend takes: the mark with its gaps, a letter, and a row [in].
LEGEND_MARK, LEGEND_LETTER, LEGEND_ROW = 0.6, 0.05, 0.16
# Type of notes, and of the axes of small panels.
SMALL = 6.5
HATCHES = {"/": "////", "x": "xxx", ".": "..."}
UNUSED_TABLES = frozenset({"GDEF", "GPOS", "GSUB", "kern", "MATH"})
# Settings of figures as matplotlib ships them: a matplotlibrc of the working folder could have a figure run LaTeX.
DEFAULTS: dict[Any, Any] = {
    name: value for name, value in rcParamsDefault.items() if not name.startswith(("backend", "interactive", "toolbar"))
}
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
    # An interval ends where it ends.
    "lines.solid_capstyle": "butt",
    # Text stays text in the PDF (TrueType), as journals ask.
    "pdf.fonttype": 42,
    # Names are text, even those with dollar signs.
    "text.parse_math": False,
}


@contextmanager
def glyphs_alone() -> Iterator[None]:
    """Embed fonts without the tables that join, replace or place glyphs: a PDF names each glyph and its place.

    To thin those out takes two thirds of the time of embedding a font, and matplotlib has no option to leave them.
    """
    load = subset.load_font

    def load_less(*given: Any, **named: Any) -> Any:
        font = load(*given, **named)
        for name in UNUSED_TABLES.intersection(font.keys()):
            del font[name]
        return font

    subset.load_font = load_less
    try:
        yield
    finally:
        subset.load_font = load


def style() -> Any:
    """Return the context in which figures are drawn and saved."""
    return rc_context({**DEFAULTS, **STYLE})


class Figure(MatplotlibFigure):
    """A figure that a notebook shows, although pyplot has not made it."""

    def _repr_png_(self) -> bytes:
        png = BytesIO()
        with style():
            FigureCanvasAgg(self).print_png(png)
        return png.getvalue()


def grid(count: int, columns: int, height: float, width: float = WIDTH) -> tuple[Figure, list[Axes]]:
    """Return a figure with so many axes in reading order; height of a row and width of the figure [in]."""
    rows = ceil(count / columns)
    figure = Figure(figsize=(width, height * rows), layout="constrained")
    FigureCanvasAgg(figure)
    places = figure.add_gridspec(rows, columns)
    return figure, [figure.add_subplot(places[i // columns, i % columns]) for i in range(count)]


def legend_above(figure: Figure, *axes: Axes) -> None:
    """Put one legend for the whole figure above it, each name once, in as many columns as fit."""
    handles: dict[str, Artist] = {}
    for ax in axes:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            handles.setdefault(str(label), handle)
    if not handles:
        return
    widths = [LEGEND_MARK + LEGEND_LETTER * len(label) for label in handles]
    width, height = figure.get_size_inches()
    columns = len(handles) if sum(widths) <= width else max(int(width / max(widths)), 1)
    figure.set_size_inches(width, height + LEGEND_ROW * (ceil(len(handles) / columns) - 1))
    figure.legend(handles.values(), handles.keys(), loc="outside upper center", ncols=columns)


def legend_over(ax: Axes, title: str) -> None:
    """Put the legend of a panel above it, under a title where there is one."""
    labels = ax.get_legend_handles_labels()[1]
    wide = sum(len(label) + 8 for label in labels) > (60 if title else 120)
    columns = (2 if title else 4) if wide else len(labels) or 1
    ax.legend(
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        borderaxespad=0.2,
        ncols=columns,
        columnspacing=1.2,
        title=title or None,
        title_fontproperties={"size": 8},
        fontsize=SMALL if title else None,
        handlelength=2.6 if title else 3.2,
    )


def figure_of(
    panels: Sequence[Panel],
    columns: int,
    height: float,
    width: float = WIDTH,
    *,
    legend: bool = True,
    titled: bool = False,
    small: bool = False,
    note: str = "",
) -> Figure:
    """Return a figure of panels in reading order; height of a row and width of the figure [in].

    legend: of all panels above the figure, unless panels have their own. titled: panels are headed by their titles. small: axes
    have small type and few numbers. note: at the foot.
    """
    figure, axes = grid(len(panels), columns, height, width)
    for ax, panel in zip(axes, panels, strict=True):
        draw(ax, panel)
        mark_edges(ax, panel)
        if panel.legend:
            legend_over(ax, panel.title)
        elif titled:
            ax.set_title(panel.title, loc="left", fontsize=7.5)
        if small:
            ax.tick_params(labelsize=SMALL)
            ax.xaxis.label.set_fontsize(SMALL)
            ax.locator_params(axis="x", nbins=3)
    if legend and not any(panel.legend for panel in panels):
        legend_above(figure, *axes)
    if note:
        figure.supxlabel(note, fontsize=SMALL, color=INKS["ink"])
    return figure


def drawn(sheet: FigureSpec) -> Figure:
    """Return the figure of a sheet."""
    return figure_of(**sheet._asdict())


def draw(ax: Axes, panel: Panel) -> None:
    """Draw a panel: its marks, and its axes around them."""
    for mark in panel.marks:
        draw_mark(ax, mark, panel)
    _show_axis(ax, "x", panel.x)
    _show_axis(ax, "y", panel.y)
    if panel.rows:
        ax.grid(visible=False, axis="y")
        ax.tick_params(axis="y", length=0)
    if panel.square:
        ax.set_aspect("equal")


def draw_mark(ax: Axes, mark: Mark, panel: Panel) -> None:
    """Draw one mark of a panel, whose edges hold points that lie beyond them."""
    label = mark.name or "_"
    match mark:
        case Points():
            _points(ax, mark, panel)
        case Line():
            _line(ax, mark, label)
        case Band():
            _band(ax, mark, label)
        case Bars():
            _bars(ax, mark, label)
        case Region():
            _region(ax, mark, label)
        case Rule():
            draw_rule = ax.axvline if mark.axis == "x" else ax.axhline
            draw_rule(mark.value, label=label, zorder=1, **stroke(mark.look))
        case Disc():
            _disc(ax, mark, label)
        case Words():
            _words(ax, mark)


class Stroke(TypedDict):
    """Properties of a line as matplotlib names them."""

    color: str
    linestyle: str
    linewidth: float


def stroke(look: Look) -> Stroke:
    """Return the line of a look; its widths are in pixels of the page."""
    return {"color": look.ink, "linestyle": look.linestyle, "linewidth": 0.65 * look.width}


def _points(ax: Axes, mark: Points, panel: Panel) -> None:
    look, x, y = mark.look, mark.x, mark.y
    sides = np.zeros((len(x), 2), dtype=int)
    if mark.edge:
        sides = np.stack([_side(x, panel.x), _side(y, panel.y)], axis=1)
        x, y = _held(x, panel.x), _held(y, panel.y)
    crossed = look.symbol == "x-thin" and mark.edge
    rows = np.ones(len(x), dtype=bool) if crossed else np.logical_not(sides.any(axis=1)).reshape(-1)
    if len(x) and not rows.any():
        return
    face = "white" if look.hollow and look.size < 15 else "none" if look.hollow else look.ink
    style: dict[str, Any] = {
        "color": look.ink,
        "markerfacecolor": face,
        "markersize": 0.45 * look.size,
        "label": mark.name or "_",
    }
    order = 6 if crossed else 4 if look.size >= 10 else 3
    if mark.x_ends or mark.y_ends:
        bars = {"xerr": _reach(mark.x, mark.x_ends, rows), "yerr": _reach(mark.y, mark.y_ends, rows)}
        ax.errorbar(x[rows], y[rows], **bars, fmt=look.marker, elinewidth=0.6, zorder=order, **style)
    else:
        ax.plot(x[rows], y[rows], look.marker, clip_on=not mark.edge, zorder=order, **style)


def _reach(values: Array, ends: tuple[Array, Array] | None, rows: Array) -> Array | None:
    """Return the distances of intervals' ends below and above their values, (2, rows)."""
    return None if ends is None else np.maximum(np.stack([values - ends[0], ends[1] - values])[:, rows], 0.0)


def _side(values: Array, axis: Axis) -> Array:
    """Return on which side of an axis values lie: -1 below, 0 within, 1 above."""
    if axis.ends is None:
        return np.zeros(len(values), dtype=int)
    return (values > axis.ends[1]).astype(int) - (values < axis.ends[0]).astype(int)


def _held(values: Array, axis: Axis) -> Array:
    return values if axis.ends is None else np.clip(values, *axis.ends)


def _line(ax: Axes, mark: Line, label: str) -> None:
    look, more = mark.look, {}
    if mark.marked is not None:
        face = "white" if look.hollow else look.ink
        more = {
            "marker": look.marker,
            "markersize": 3,
            "markerfacecolor": face,
            "markeredgewidth": 0.7,
            "markevery": mark.marked,
        }
    draw_line = ax.step if mark.steps else ax.plot
    where = {"where": "post"} if mark.steps else {}
    # References and hair lines lie behind the others.
    order = 2 if look == REFERENCE else 2.8 if look.width < 1.0 else 3
    draw_line(mark.x, mark.y, label=label, zorder=order, **stroke(look), **where, **more)


def _band(ax: Axes, mark: Band, label: str) -> None:
    look, hatch = mark.look, HATCHES.get(mark.look.symbol)
    if hatch:
        ax.fill_between(
            mark.x,
            mark.low,
            mark.high,
            facecolor="none",
            edgecolor=look.ink,
            hatch=hatch,
            alpha=look.opacity,
            linewidth=0.8,
            label=label,
        )
    else:
        ax.fill_between(mark.x, mark.low, mark.high, color=look.ink, alpha=look.opacity, linewidth=0, label=label)


def _bars(ax: Axes, mark: Bars, label: str) -> None:
    if not mark.across:
        ax.bar(mark.x, mark.y, width=mark.width, color=mark.look.ink, label=label)
        return
    ax.barh(mark.y, mark.x, height=mark.width, color=mark.look.ink, label=label)
    if mark.ends:
        # A percentile interval may leave its estimate out by a hair; a whisker has no negative length.
        whiskers = _reach(mark.x, mark.ends, np.ones(len(mark.x), dtype=bool))
        ax.errorbar(mark.x, mark.y, xerr=whiskers, fmt="none", ecolor=INKS["ink"], elinewidth=0.7, capsize=1.5)


def _region(ax: Axes, mark: Region, label: str) -> None:
    look, hatch = mark.look, HATCHES.get(mark.look.symbol)
    # What lies below must not shine through, so the ink is thinned with white instead of made transparent.
    face = tuple(1.0 - look.opacity * (1.0 - part) for part in to_rgb(look.ink))
    values, outline = np.ma.masked_invalid(mark.values), [end for end in mark.ends if abs(end) < FAR]
    filled = ax.contourf(mark.x, mark.y, values, levels=mark.ends, colors=[face], hatches=[hatch])
    filled.set_edgecolor(look.ink)
    filled.set_linewidth(0.0)
    if look.width and any(values.min() < end < values.max() for end in outline):
        ax.contour(
            mark.x,
            mark.y,
            values,
            levels=outline,
            colors=[INKS["ink"]],
            linewidths=0.65 * look.width,
            linestyles=[look.linestyle],
        )
    ax.fill([], [], facecolor=face, edgecolor=look.ink, hatch=hatch, linewidth=0.3, label=label)


def _disc(ax: Axes, mark: Disc, label: str) -> None:
    look = mark.look
    ax.add_patch(
        Circle(
            (mark.x, mark.y),
            mark.radius,
            facecolor=look.ink if mark.fill == "filled" else "none",
            edgecolor=look.ink,
            hatch=HATCHES["/"] if mark.fill == "hatched" else None,
            linewidth=0.8,
            linestyle=look.linestyle,
            alpha=look.opacity,
            label=label,
        )
    )


def _words(ax: Axes, mark: Words) -> None:
    words = ax.text(mark.x, mark.y, mark.text, fontsize=SMALL, color=mark.look.ink)
    if mark.place == "right":
        words.set(transform=ax.get_yaxis_transform(), va="center")
    elif mark.place == "inside":
        words.set(transform=ax.transAxes, ha="right", va="center")


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
        # The usual labels are powers in mathematical type, which texts that nobody wrote here forbid (`text.parse_math`).
        line.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    if axis.ticks:
        line.set_major_locator(FixedLocator([value for value, _ in axis.ticks]))
        line.set_minor_locator(NullLocator())
        line.set_ticklabels([text for _, text in axis.ticks])
    elif axis.step and not axis.log and axis.ends:
        line.set_major_locator(FixedLocator(np.arange(axis.ends[0], axis.ends[1] + 1e-9, axis.step).tolist()))
    if axis.ends:
        ax.set(**{f"{name}lim": axis.ends})
    if axis.bare:
        line.set_tick_params(labelbottom=False, labelleft=False)
    else:
        line.set_label_text(axis.title)


def make_ready() -> None:
    """Print a word, so that fonts are read."""
    with style():
        figure = Figure(figsize=(1.0, 1.0))
        figure.text(0.0, 0.5, "ready")
        printed(figure)


def files_of(sheets: Mapping[str, FigureSpec]) -> dict[str, bytes]:
    """Return the files of figures by their names in a results folder."""
    files: dict[str, bytes] = {}
    with style():
        for name, sheet in sheets.items():
            files |= {f"figures/{name}{ending}": content for ending, content in printed(drawn(sheet)).items()}
    return files


def printed(figure: Figure) -> dict[str, bytes]:
    """Return a figure as ".png" and ".pdf", without a date so that the same results give the same bytes.

    Printed by the canvases themselves, because `Figure.savefig` draws everything a second time for its bounding box.
    The layout of the first file serves the second.
    """
    png, pdf = BytesIO(), BytesIO()
    figure.set_dpi(DPI)
    FigureCanvasAgg(figure).print_png(png)
    figure.set_layout_engine("none")
    with glyphs_alone():
        FigureCanvasPdf(figure).print_pdf(pdf, metadata={"CreationDate": None})
    return {".png": png.getvalue(), ".pdf": pdf.getvalue()}
