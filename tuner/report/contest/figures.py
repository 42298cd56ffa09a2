"""Figures for a paper: front, differences, printed numbers, and time responses in the order of Wu et al.'s figures 6 to 12."""

from collections.abc import Callable
from pathlib import Path

from matplotlib import rc_context
from matplotlib.figure import Figure

from tuner.documents.contest import Contest
from tuner.documents.contest_loading import load_contest
from tuner.report.contest import time_figures
from tuner.report.contest.differences_figure import differences_figure
from tuner.report.contest.fronts_figure import fronts_figure
from tuner.report.contest.published_figure import published_figure
from tuner.report.figure_style import save, style

# File name and what draws it; None where the folder has no data for it.
FIGURES: dict[str, Callable[[Contest], Figure | None]] = {
    "front": fronts_figure,
    "differences": differences_figure,
    "published": published_figure,
    "06_position_disturbance": time_figures.position_disturbance,
    "07_attitude_disturbance": time_figures.attitude_disturbance,
    "08_position": time_figures.positions,
    "09_attitude": time_figures.angles,
    "10_position_error": time_figures.position_errors,
    "11_attitude_error": time_figures.angle_errors,
    "12_angular_rate": time_figures.angle_rates,
}


def write_all(folder: Path) -> list[Path]:
    """Write every figure that the folder has data for and return the files; StoreError where that cannot be done."""
    contest = load_contest(folder)
    # Names are text, even those with dollar signs.
    with style(), rc_context({"text.parse_math": False}):
        drawn = {name: draw(contest) for name, draw in FIGURES.items()}
        shown = {name: figure for name, figure in drawn.items() if figure is not None}
        return [file for name, figure in shown.items() for file in save(figure, folder, f"figures/{name}")]
