"""The chart of a sensitivity analysis: first-order and total indices of every output, with 95 % intervals."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tuner.analysis.sensitivity.analysis import Analysis
from tuner.analysis.sensitivity.document import FAILURE, outputs
from tuner.analysis.sensitivity.indices import RANK, Spans
from tuner.report.charts.look import INKS
from tuner.report.charts.paper import WIDTH, grid, legend_above, save, style
from tuner.study.study import Study

# Height of a bar and its offset from the middle, in rows; height of a row and of what stands around the rows [in].
BAR, ROW, AROUND = 0.36, 0.28, 0.85


def write_figure(study: Study, analysis: Analysis, folder: Path) -> list[Path]:
    """Write figures/sensitivity.png and .pdf into a folder and return their paths."""
    with style():
        return save(sensitivity_figure(study, analysis), folder, "figures/sensitivity")


def sensitivity_figure(study: Study, analysis: Analysis) -> Figure:
    """Return the chart; an output that never changes has no panel, unless none does."""
    indices, names = analysis.indices[RANK], outputs(study)
    shown = [q for q in range(len(names)) if indices.total.value[q].any()] or [0]
    variables = [variable.name for variable in study.space.variables]
    columns = min(len(shown), 3)
    figure, axes = grid(len(shown), columns, AROUND + ROW * len(variables), WIDTH)
    for ax, q in zip(axes, shown, strict=True):
        _bars(ax, indices.total, q, -0.5 * BAR, "total: alone and with all others", INKS["faint"])
        _bars(ax, indices.first, q, 0.5 * BAR, "first order: alone", INKS["tuned"])
        ax.set_title(names[q] if names[q] == FAILURE else f"rank of {names[q]}", loc="left")
        ax.set_yticks(np.arange(len(variables)), variables)
        ax.invert_yaxis()
        ax.set_xlim(left=min(0.0, float(ax.get_xlim()[0])))
        ax.set_xlabel("share of the variance")
        ax.grid(visible=False, axis="y")
        ax.tick_params(axis="y", length=0)
    for k, ax in enumerate(axes):
        if k % columns:
            ax.set_yticklabels([])
    legend_above(figure, axes[0])
    return figure


def _bars(ax: Axes, spans: Spans, output: int, offset: float, label: str, colour: str) -> None:
    value, low, high = (part[output] for part in spans)
    places = np.arange(len(value)) + offset
    # A percentile interval may leave its estimate out by a hair; a whisker has no negative length.
    whiskers = np.maximum(np.stack([value - low, high - value]), 0.0)
    ax.barh(places, value, height=BAR, color=colour, label=label)
    ax.errorbar(value, places, xerr=whiskers, fmt="none", ecolor=INKS["ink"], elinewidth=0.7, capsize=1.5)
