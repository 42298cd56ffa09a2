"""Printed numbers for a paper: our central 95 % of flights with median, and the printed number in the same row."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tuner.documents.contest import Cell, Contest
from tuner.report.contest.figure_axes import show_span
from tuner.report.contest.published_section import percentile_text, rows_of
from tuner.report.contest.spans import span_of
from tuner.report.contest.strip import LOG_FACTOR
from tuner.report.figure_style import COLOURS, grid
from tuner.text.units import bracketed

# Panels a row, and the least height of one [in], below which axis and labels have no room.
COLUMNS, LEAST = 2, 1.3


def published_figure(contest: Contest) -> Figure | None:
    """Return a panel for each row of the printed table; None where no number was printed."""
    rows = rows_of(contest.cells)
    if not rows:
        return None
    groups = [[cell for cell in contest.cells if (cell.metric, cell.scenario) == row] for row in rows]
    most = max(len(cells) for cells in groups)
    columns = min(COLUMNS, len(rows))
    figure, axes = grid(len(rows), columns, max(0.75 + 0.18 * most, LEAST))
    same = all([cell.contender for cell in cells] == [cell.contender for cell in groups[0]] for cells in groups)
    for number, (ax, cells) in enumerate(zip(axes, groups, strict=True)):
        _panel(contest, ax, cells, named=number % columns == 0 or not same)
    _legend(figure, axes[0])
    return figure


def _panel(contest: Contest, ax: Axes, cells: list[Cell], named: bool) -> None:
    for row, cell in enumerate(cells):
        look, (median, low, high) = contest.look[cell.contender], cell.central
        if median is not None and low is not None and high is not None:
            ax.plot([low, high], [-row, -row], color=look.ink, linewidth=5, alpha=0.35, solid_capstyle="butt")
            ax.plot([median], [-row], "|", markersize=9, markeredgewidth=1.8, color=look.ink)
        face = COLOURS["ink"] if cell.inside else "white"
        pin = {"markersize": 5, "markerfacecolor": face, "markeredgecolor": COLOURS["ink"], "zorder": 4}
        ax.plot([cell.printed], [-row + 0.12], "v", **pin)
        place = {"transform": ax.get_yaxis_transform(), "va": "center", "fontsize": 6.5}
        ax.text(1.01, -row, f"{percentile_text(cell.percentile)} %{'*' if cell.fitted else ''}", **place)
    names = [cell.contender for cell in cells] if named else [""] * len(cells)
    ax.set_yticks([-row for row in range(len(cells))], names, fontsize=7)
    ax.set_ylim(0.5 - len(cells), 0.7)
    ax.grid(visible=False, axis="y")
    ax.set_xlabel(f"{bracketed(cells[0].metric, cells[0].unit)}\nscenario {cells[0].scenario}", fontsize=7.5)
    _stretch(ax, [number for cell in cells for number in (*cell.central, cell.printed) if number is not None])


def _stretch(ax: Axes, numbers: list[float]) -> None:
    """Show all numbers, from zero where they do not cover decades."""
    span = span_of([np.array(numbers)], LOG_FACTOR)
    show_span(ax, "x", span if span.log else span_of([np.array([0.0, *numbers])]))


def _legend(figure: Figure, ax: Axes) -> None:
    ink = {"linestyle": "none", "markeredgecolor": COLOURS["ink"], "markersize": 5}
    handles = [
        ax.plot([], [], color=COLOURS["grey"], linewidth=5, alpha=0.6)[0],
        ax.plot([], [], "|", color=COLOURS["grey"], markersize=9, markeredgewidth=1.8, linestyle="none")[0],
        ax.plot([], [], "v", markerfacecolor=COLOURS["ink"], **ink)[0],
        ax.plot([], [], "v", markerfacecolor="white", **ink)[0],
    ]
    labels = ["central 95 % of our flights", "their median", "printed, inside", "printed, outside"]
    figure.legend(handles, labels, loc="outside upper center", ncols=4)
    note = "right: percentile of the printed number among our flights; *: the study was set to meet it"
    figure.supxlabel(note, fontsize=6.5)
