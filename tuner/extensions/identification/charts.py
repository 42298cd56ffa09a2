"""Charts of an identification: predictions on held-out windows, residuals and their whiteness, frequency responses."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from tuner.extensions.identification.building import QUANTILE, UNITS
from tuner.extensions.identification.document import ResponseRow
from tuner.extensions.identification.identify import Identified
from tuner.extensions.identification.response_comparison import DECIBELS, MIN_COHERENCE, bands_of
from tuner.extensions.vehicle_fit.samples import OUTPUTS
from tuner.report.charts.chart import Array, Axis, Band, Line, Mark, Panel, Rule
from tuner.report.charts.look import BOUND, Look
from tuner.report.charts.paper import Figure, figure_of

SHOWN = 12
"""Windows that are drawn, those with the most motion."""
HEIGHT = 3.0
MEASURED, MODELLED, BAND, STEM = Look("default"), Look("tuned"), Look("tuned", opacity=0.22), Look("tuned", width=4.0)
MEASURED_BAND = Look("default", opacity=0.22)


def prediction_figure(fit: Identified) -> Figure | None:
    """Return the chart of the windows for paper; None without held-out windows."""
    panels = prediction_panels(fit)
    return figure_of(panels, 2, HEIGHT, titled=True) if panels else None


def prediction_panels(fit: Identified) -> list[Panel]:
    """Return a panel for each output: prediction with 95 % band, measurement; none without held-out windows."""
    validation, panels = fit.validation, []
    if validation.windows.is_empty:
        return []
    for k, (name, unit) in enumerate(zip(OUTPUTS, UNITS, strict=True)):
        measured, modeled = validation.windows.measured[..., k], validation.windows.modeled[..., k]
        most = np.sort(np.argsort(-np.std(measured, axis=1))[:SHOWN])
        measured, modeled, width = (
            series[most] for series in (measured, modeled, QUANTILE * validation.spread[..., k])
        )
        period = float(np.median(np.diff(validation.windows.time, axis=1)))
        time = period * np.arange(measured.size).reshape(measured.shape)
        marks: list[Mark] = [
            Band(name="95 % band" if i == 0 else "", look=BAND, x=x, low=y - w, high=y + w)
            for i, (x, y, w) in enumerate(zip(time, modeled, width, strict=True))
        ]
        marks += [
            Line(name=name, look=look, x=_broken(time), y=_broken(series))
            for name, look, series in (("predicted", MODELLED, modeled), ("measured", MEASURED, measured))
        ]
        x = Axis("windows one after the other [s]")
        panels.append(Panel(f"prediction-{name}", name, x, Axis(f"{name} [{unit}]"), marks))
    return panels


def spectrum_panels(fit: Identified) -> list[Panel]:
    """Return a panel for each output: the spectrum of what was measured and of what the model leaves over.

    None without held-out windows.
    """
    if fit.windows.is_empty:
        return []
    frequency, measured, left = fit.validation.spectra
    panels = []
    for k, (name, unit) in enumerate(zip(OUTPUTS, UNITS, strict=True)):
        marks = [
            Line(name="measured", look=MEASURED, x=frequency, y=measured[:, k]),
            Line(name="left over", look=MODELLED, x=frequency, y=left[:, k]),
        ]
        x, y = Axis("frequency [Hz]", log=True), Axis(f"{unit} / sqrt(Hz)", log=True)
        panels.append(Panel(f"spectrum-{name}", name, x, y, marks))
    return panels


def whiteness_panels(fit: Identified) -> list[Panel]:
    """Return a panel for each output: autocorrelations of what the noise model leaves over, with the bound of white noise."""
    validation, panels = fit.validation, []
    lags = np.arange(1.0, 1.0 + len(validation.correlation))
    for k, name in enumerate(OUTPUTS):
        marks = [
            Line(look=STEM, x=_broken(np.stack([lags, lags], axis=1)), y=_broken(_stems(validation.correlation[:, k]))),
            *[Rule(look=BOUND, axis="y", value=sign * validation.bound) for sign in (-1.0, 1.0)],
        ]
        panels.append(
            Panel(
                f"whiteness-{name}",
                name,
                Axis("lag [samples]", 0.0, lags[-1] + 1.0),
                Axis("autocorrelation", -0.3, 0.3),
                marks,
            )
        )
    return panels


def figures_of(identified: Identified) -> Mapping[str, Callable[[], Figure | None]]:
    """Return the figures of an identification by name."""
    return {"prediction": lambda: prediction_figure(identified)}


def response_panels(rows: Sequence[ResponseRow]) -> list[Panel]:
    """Return three panels for each output: magnitude and phase next to the model's with 95 % bands, and coherence."""
    return [panel for row in rows for panel in _response(row)]


def _response(row: ResponseRow) -> list[Panel]:
    frequency, coherence = np.array(row.frequency), np.array(row.coherence)
    width = np.array(row.half_width)
    compared = np.array(row.compared)
    x = Axis("frequency [Hz]", log=True)
    panels = []
    for name, unit, values, widths, model, model_width in (
        ("magnitude", "dB", row.magnitude, width, row.model_magnitude, row.model_half_width),
        ("phase", "degrees", row.phase, np.degrees(width / DECIBELS), row.model_phase, row.model_phase_half_width),
    ):
        y, middle, wide = np.array(values), np.array(model), np.array(model_width)
        marks: list[Mark] = [
            Band(look=MEASURED_BAND, x=frequency[band], low=(y - widths)[band], high=(y + widths)[band])
            for band in bands_of(compared)
        ]
        marks += [
            Band(look=BAND, x=frequency, low=middle - wide, high=middle + wide),
            Line(name="model", look=MODELLED, x=frequency, y=middle),
            Line(name="logs", look=MEASURED, x=frequency, y=np.where(compared, y, np.nan)),
        ]
        panels.append(Panel(f"response-{row.output}-{name}", row.output, x, Axis(f"{name} [{unit}]"), marks))
    marks = [Line(look=MEASURED, x=frequency, y=coherence), Rule(look=BOUND, axis="y", value=MIN_COHERENCE)]
    panels.append(Panel(f"response-{row.output}-coherence", row.output, x, Axis("coherence", 0.0, 1.0), marks))
    return panels


def _stems(heights: Array) -> Array:
    return np.stack([np.zeros_like(heights), heights], axis=1)


def _broken(series: Array) -> Array:
    """Return the rows of a series (n, m) joined, with gaps between."""
    return np.append(series, np.full((len(series), 1), np.nan), axis=1).ravel()
