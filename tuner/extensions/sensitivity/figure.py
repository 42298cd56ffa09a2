"""The chart of a sensitivity analysis: first-order and total indices of every output, with 95 % intervals."""

from pathlib import Path

import numpy as np

from tuner.api.figures import Drawers
from tuner.extensions.sensitivity.analysis import Analysis
from tuner.extensions.sensitivity.indices import RANK, Spans
from tuner.extensions.sensitivity.tables import FAILURE, outputs
from tuner.report.charts.chart import Axis, Bars, Panel, row_axis
from tuner.report.charts.files import save
from tuner.report.charts.look import Look
from tuner.report.charts.paper import Figure, figure_of, style
from tuner.study.study import TuningStudy

# Height of a bar and its offset from the middle, in rows; height of a row and of what stands around the rows [in].
BAR, ROW, AROUND = 0.36, 0.28, 0.85
COLUMNS = 3


def write_figure(study: TuningStudy, analysis: Analysis, folder: Path) -> list[Path]:
    """Write figures/sensitivity.png and .pdf into a folder and return their paths."""
    with style():
        return save(sensitivity_figure(study, analysis), folder, "figures/sensitivity")


def figures_of(study: TuningStudy, analysis: Analysis) -> Drawers:
    """Return the figures of an analysis by name."""
    return {"sensitivity": lambda: sensitivity_figure(study, analysis)}


def sensitivity_figure(study: TuningStudy, analysis: Analysis) -> Figure:
    """Return the chart; an output that never changes has no panel, unless none does."""
    indices, names = analysis.indices[RANK], outputs(study)
    shown = [q for q in range(len(names)) if indices.total.value[q].any()] or [0]
    variables = [variable.name for variable in study.space.variables]
    panels = []
    for k, q in enumerate(shown):
        marks = [
            _bars(indices.total, q, 0.5 * BAR, "total: alone and with all others", Look("faint")),
            _bars(indices.first, q, -0.5 * BAR, "first order: alone", Look("tuned")),
        ]
        title = names[q] if names[q] == FAILURE else f"rank of {names[q]}"
        rows = row_axis(variables if k % COLUMNS == 0 else [""] * len(variables))
        panels.append(Panel("", title, Axis("share of the variance"), rows, marks, rows=True))
    return figure_of(panels, min(len(shown), COLUMNS), AROUND + ROW * len(variables), titled=True)


def _bars(spans: Spans, output: int, offset: float, name: str, look: Look) -> Bars:
    value, low, high = (part[output] for part in spans)
    places = offset - np.arange(len(value))
    return Bars(name=name, look=look, x=value, y=places, ends=(low, high), across=True, width=BAR)
