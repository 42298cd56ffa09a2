"""Figures for a paper: fronts, differences, and time responses in the order of Wu et al.'s figures 6 to 12."""

from collections.abc import Callable, Mapping
from pathlib import Path

from tuner.documents.comparison import ComparedFolder
from tuner.report.charts.files import save
from tuner.report.charts.paper import Figure, figure_of, style
from tuner.report.charts.sheet import WIDTH
from tuner.report.comparison import time_figures
from tuner.report.comparison.fronts_panels import fronts_panels
from tuner.report.comparison.row_panels import difference_panels, value_panels

COLUMNS = 3
Drawn = Mapping[str, Callable[[ComparedFolder], Figure | None]]
"""Figures by file name, each None where the folder has no data for it."""


def fronts_figure(compared: ComparedFolder) -> Figure | None:
    """Return the fronts of all contenders, for one objective the points in rows; None where nothing was tuned."""
    panels = fronts_panels(compared)
    if not panels:
        return None
    if panels[0].rows:
        return figure_of(panels, 1, 0.9 + 0.3 * len(panels[0].y.ticks), 0.75 * WIDTH)
    single = len(panels) == 1
    return figure_of(panels, min(len(panels), 3), 3.6 if single else 2.5, 0.85 * WIDTH if single else WIDTH)


def differences_figure(compared: ComparedFolder) -> Figure | None:
    """Return forest plots of the paired differences; None where no two contenders differ in anything."""
    panels = difference_panels(compared, COLUMNS)
    if not panels:
        return None
    rows = max(len(panel.y.ticks) for panel in panels)
    note = "left of zero the one named first is lower; hollow: neither is better"
    return figure_of(panels, min(COLUMNS, len(panels)), 0.7 + 0.15 * rows, small=True, note=note)


def values_figure(compared: ComparedFolder) -> Figure:
    """Return every value with its interval, of the first quantities where there are more than fit on a page."""
    panels = value_panels(compared, COLUMNS)
    note = "bars: 95 % intervals over flights; dashed: limit; further left is better"
    return figure_of(panels, min(COLUMNS, len(panels)), 0.75 + 0.2 * len(compared.contenders), small=True, note=note)


FIGURES: Drawn = {
    "front": fronts_figure,
    "differences": differences_figure,
    "responses": time_figures.channels,
    "06_position_disturbance": time_figures.position_disturbance,
    "07_attitude_disturbance": time_figures.attitude_disturbance,
    "08_position": time_figures.positions,
    "09_attitude": time_figures.angles,
    "10_position_error": time_figures.position_errors,
    "11_attitude_error": time_figures.angle_errors,
    "12_angular_rate": time_figures.angle_rates,
}


def write_all(compared: ComparedFolder, figures: Drawn) -> list[Path]:
    """Write every figure that a folder has data for and return the files; StoreError where that cannot be done."""
    with style():
        drawn = {name: draw(compared) for name, draw in figures.items()}
        shown = {name: figure for name, figure in drawn.items() if figure is not None}
        return [file for name, figure in shown.items() for file in save(figure, compared.home, f"figures/{name}")]
