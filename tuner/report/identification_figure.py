"""The chart of an identification: what was measured and what the model predicts, on windows that were kept from the fit."""

import numpy as np

from tuner.analysis.identification.document import QUANTILE, UNITS
from tuner.analysis.identification.identify import Identified
from tuner.analysis.identification.samples import OUTPUTS
from tuner.report.charts.chart import Axis, Band, Line, Panel
from tuner.report.charts.look import Look
from tuner.report.charts.paper import Figure, figure_of

SHOWN = 12
"""Windows that are drawn, those with the most motion."""
HEIGHT = 3.0


def prediction_figure(found: Identified) -> Figure:
    """Return the chart, a panel for each output; the band holds 95 % of the errors of all windows."""
    panels = []
    for k, (name, unit) in enumerate(zip(OUTPUTS, UNITS, strict=True)):
        measured, modelled = found.windows.measured[..., k], found.windows.modelled[..., k]
        most = np.sort(np.argsort(-np.std(measured, axis=1))[:SHOWN])
        width = QUANTILE * found.windows.errors[k]
        parts = [
            np.append(series[most], np.full((len(most), 1), np.nan), axis=1).ravel() for series in (measured, modelled)
        ]
        time = np.arange(len(parts[0])) * float(np.median(np.diff(found.windows.time, axis=1)))
        marks = [
            Band(name="95 % of the errors", look=Look("faint"), x=time, low=parts[1] - width, high=parts[1] + width),
            Line(name="predicted", look=Look("tuned"), x=time, y=parts[1]),
            Line(name="measured", look=Look("default"), x=time, y=parts[0]),
        ]
        panels.append(Panel("", name, Axis("windows one after the other [s]"), Axis(f"{name} [{unit}]"), marks))
    return figure_of(panels, 2, HEIGHT, titled=True)
