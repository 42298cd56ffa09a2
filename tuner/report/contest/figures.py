"""Figures for a paper: fronts, differences, printed numbers, and time responses in the order of Wu et al.'s figures 6 to 12."""

from collections.abc import Callable
from pathlib import Path

from tuner.documents.contest import ComparedFolder, open_compared
from tuner.report.charts.files import save
from tuner.report.charts.paper import Figure, figure_of, style
from tuner.report.charts.sheet import WIDTH
from tuner.report.contest import time_figures
from tuner.report.contest.fronts_panels import fronts_panels
from tuner.report.contest.row_panels import difference_panels, printed_panels, value_panels

COLUMNS = 3


def fronts_figure(contest: ComparedFolder) -> Figure | None:
    """Return the fronts of all contenders, for one objective the points in rows; None where nothing was tuned."""
    panels = fronts_panels(contest)
    if not panels:
        return None
    if panels[0].rows:
        return figure_of(panels, 1, 0.9 + 0.3 * len(panels[0].y.ticks), 0.75 * WIDTH)
    single = len(panels) == 1
    return figure_of(panels, min(len(panels), 3), 3.6 if single else 2.5, 0.85 * WIDTH if single else WIDTH)


def differences_figure(contest: ComparedFolder) -> Figure | None:
    """Return forest plots of the paired differences; None where no two contenders differ in anything."""
    panels = difference_panels(contest, COLUMNS)
    if not panels:
        return None
    rows = max(len(panel.y.ticks) for panel in panels)
    note = "left of zero the one named first is lower; hollow: neither is better"
    return figure_of(panels, min(COLUMNS, len(panels)), 0.7 + 0.15 * rows, small=True, note=note)


def values_figure(contest: ComparedFolder) -> Figure:
    """Return every value with its interval, of the first quantities where there are more than fit on a page."""
    panels = value_panels(contest, COLUMNS)
    note = "bars: 95 % intervals over flights; dashed: limit; further left is better"
    return figure_of(panels, min(COLUMNS, len(panels)), 0.75 + 0.2 * len(contest.contenders), small=True, note=note)


def published_figure(contest: ComparedFolder) -> Figure | None:
    """Return our central 95 % of flights with each printed number; None where no number was printed."""
    panels = printed_panels(contest)
    if not panels:
        return None
    rows = max(len(panel.y.ticks) for panel in panels)
    note = "right: percentile of the printed number among our flights; *: the study was set to meet it"
    return figure_of(panels, min(2, len(panels)), max(0.75 + 0.18 * rows, 1.3), note=note)


# File name and what draws it; None where the folder has no data for it.
FIGURES: dict[str, Callable[[ComparedFolder], Figure | None]] = {
    "front": fronts_figure,
    "differences": differences_figure,
    "published": published_figure,
    "responses": time_figures.channels,
    "06_position_disturbance": time_figures.position_disturbance,
    "07_attitude_disturbance": time_figures.attitude_disturbance,
    "08_position": time_figures.positions,
    "09_attitude": time_figures.angles,
    "10_position_error": time_figures.position_errors,
    "11_attitude_error": time_figures.angle_errors,
    "12_angular_rate": time_figures.angle_rates,
}


def write_all(folder: Path, values: bool = False) -> list[Path]:
    """Write every figure that the folder has data for and return the files; StoreError where that cannot be done.

    values: with values.png and .pdf, those of a comparison.
    """
    contest = open_compared(folder)
    figures = {"values": values_figure, **FIGURES} if values else FIGURES
    with style():
        drawn = {name: draw(contest) for name, draw in figures.items()}
        shown = {name: figure for name, figure in drawn.items() if figure is not None}
        return [file for name, figure in shown.items() for file in save(figure, folder, f"figures/{name}")]
