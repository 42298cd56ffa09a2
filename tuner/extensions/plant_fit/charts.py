"""Charts of a fit: data and model, residuals and their whiteness, step and frequency responses with bands."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tuner.extensions.plant_fit.building import autocorrelation
from tuner.extensions.plant_fit.estimate import simulated
from tuner.extensions.plant_fit.intervals import NORMAL_QUANTILE, FittedPlant
from tuner.extensions.plant_fit.response import SampledFilter
from tuner.report.charts.chart import Array, Axis, Band, Line, Mark, Panel, Rule
from tuner.report.charts.look import BOUND, Look
from tuner.report.charts.paper import Figure, figure_of
from tuner.text.units import bracketed

if TYPE_CHECKING:
    from tuner.extensions.plant_fit.result import PlantFit

HEIGHT = 3.0
MEASURED_LOOK, MODEL_LOOK, BAND, STEM = (
    Look("default"),
    Look("tuned"),
    Look("tuned", opacity=0.22),
    Look("tuned", width=4.0),
)
INPUT, LEFT_LOOK = Look("front"), Look("other", width=1.0)
N_POINTS = 240
"""Points of a response."""
MAX_POINTS = 4000
"""Samples of a record that are drawn, evenly thinned out."""
DECIBELS = 20.0 / float(np.log(10.0))


def data_panels(fit: "PlantFit") -> list[Panel]:
    """Return a panel for each input and each output: measurement, and what the model makes of the inputs."""
    time = _joined([each.time - each.time[0] for each in fit.experiments], shifted=True)
    x = Axis("time [s], records one after the other" if len(fit.experiments) > 1 else "time [s]")
    panels = []
    for i, (name, plant) in enumerate(zip(fit.signals.outputs, fit.plants, strict=True)):
        measured = [each.outputs[:, i] for each in fit.experiments]
        model = simulated(plant.chosen.projection, plant.solution)
        marks: list[Mark] = [
            Line(name="measured", look=MEASURED_LOOK, x=time, y=_joined(measured)),
            Line(name="model", look=MODEL_LOOK, x=time, y=_joined(model)),
        ]
        panels.append(Panel(f"data-{name}", name, x, Axis(bracketed(name, fit.signals.units[name])), marks))
    for j, name in enumerate(fit.signals.inputs):
        marks = [
            Line(
                name="input", look=INPUT, x=time, y=_joined([each.inputs[:, j] for each in fit.experiments]), steps=True
            )
        ]
        panels.append(Panel(f"data-{name}", name, x, Axis(bracketed(name, fit.signals.units[name])), marks))
    return panels


def residual_panels(fit: "PlantFit") -> list[Panel]:
    """Return two panels for each output: what the model leaves over, and autocorrelations of the prediction errors."""
    time = _joined([each.time - each.time[0] for each in fit.experiments], shifted=True)
    panels = []
    for i, (name, plant) in enumerate(zip(fit.signals.outputs, fit.plants, strict=True)):
        # The offsets are those of the model in the first panels: those of the prediction errors can be far from the record.
        model = simulated(plant.chosen.projection, plant.solution)
        left = [each.outputs[:, i] - part for each, part in zip(fit.experiments, model, strict=True)]
        line = Line(look=LEFT_LOOK, x=time, y=_joined(left))
        unit = bracketed("left over", fit.signals.units[name])
        panels.append(Panel(f"left-{name}", f"{name}, left over", Axis("time [s]"), Axis(unit), [line]))
        panels.append(_whiteness(name, plant))
    return panels


def _whiteness(name: str, plant: FittedPlant) -> Panel:
    values, bound = autocorrelation(plant.solution.errors)
    lags = np.arange(1.0, 1.0 + len(values))
    gaps = np.full(len(lags), np.nan)
    stems = Line(
        look=STEM,
        x=np.stack([lags, lags, gaps], axis=1).ravel(),
        y=np.stack([np.zeros(len(lags)), values, gaps], axis=1).ravel(),
    )
    rules = [Rule(look=BOUND, axis="y", value=sign * bound) for sign in (-1.0, 1.0)]
    edge = max(0.3, 1.1 * float(np.abs(values).max(initial=0.0)))
    x = Axis("lag [samples]", 0.0, len(lags) + 1.0)
    return Panel(
        f"white-{name}", f"{name}, prediction errors", x, Axis("autocorrelation", -edge, edge), [stems, *rules]
    )


def step_panels(fit: "PlantFit") -> list[Panel]:
    """Return a panel for each pair of input and output: the response to a unit step with its 95 % band."""
    panels = []
    for plant, name in zip(fit.plants, fit.signals.outputs, strict=True):
        for j, source in enumerate(fit.signals.inputs):
            time, value, spread = step_response(plant, j)
            marks: list[Mark] = [
                Band(name="95 % band", look=BAND, x=time, low=value - spread, high=value + spread),
                Line(name="model", look=MODEL_LOOK, x=time, y=value),
            ]
            units = f"{fit.signals.units[name]}/{fit.signals.units[source]}"
            y = Axis(bracketed(f"{name} for a unit of {source}", "" if units == "1/1" else units))
            panels.append(Panel(f"step-{name}-{source}", f"{source} to {name}", Axis("time [s]"), y, marks))
    return panels


def step_response(plant: FittedPlant, j: int) -> tuple[Array, Array, Array]:
    """Return times [s], unit step response (k,), and half-width of its band."""
    numerator, denominator = plant.coefficients(j)
    poles = np.roots(denominator)
    moving = poles[np.abs(poles) > 1e-9 * max(np.abs(poles).max(initial=0.0), 1e-300)]
    slow = float(np.max(1.0 / np.maximum(np.abs(moving.real), 1e-12), initial=0.0))
    span = 5.0 * slow + 1.5 * float(plant.solution.dead_times[j])
    span = min(span if span > 0.0 else plant.chosen.problem.span, 2.0 * plant.chosen.problem.span)
    period = span / N_POINTS
    step = np.ones(N_POINTS)

    def response(parameters: Array) -> Array:
        above, below = plant.coefficients(j, parameters)
        late = max(float(plant.parts(parameters)[1][j]), 0.0)
        parts = SampledFilter(below, period).responses(step, late, len(above))
        return above[::-1] @ np.array(parts)

    value, covariance = plant.deviations(response)
    spread = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return period * np.arange(N_POINTS), value, NORMAL_QUANTILE * spread


def bode_panels(fit: "PlantFit") -> list[Panel]:
    """Return magnitude and phase of each pair with 95 % bands."""
    panels = []
    for plant, name in zip(fit.plants, fit.signals.outputs, strict=True):
        for j, source in enumerate(fit.signals.inputs):
            frequency = _frequencies(plant, j)
            size, angle, spread = plant.response(j, frequency)
            parts = (
                ("magnitude", "dB", DECIBELS * size, DECIBELS * spread[0]),
                ("phase", "degrees", np.degrees(angle), np.degrees(spread[1])),
            )
            for kind, unit, value, deviation in parts:
                width = NORMAL_QUANTILE * deviation
                marks: list[Mark] = [
                    Band(name="95 % band", look=BAND, x=frequency, low=value - width, high=value + width),
                    Line(name="model", look=MODEL_LOOK, x=frequency, y=value),
                ]
                x = Axis("frequency [rad/s]", log=True)
                panels.append(
                    Panel(f"bode-{name}-{source}-{kind}", f"{source} to {name}", x, Axis(f"{kind} [{unit}]"), marks)
                )
    return panels


def _frequencies(plant: FittedPlant, j: int) -> Array:
    """Return frequencies [rad/s] around the corner frequency of a plant."""
    corner = SampledFilter(plant.coefficients(j)[1], 1.0).pace
    if plant.solution.structure.n_shape == 0:
        corner = 10.0 / plant.chosen.problem.span
    return np.geomspace(0.02 * corner, min(50.0 * corner, np.pi / plant.chosen.problem.period), N_POINTS)


def figures_of(fit: "PlantFit") -> Mapping[str, Callable[[], Figure]]:
    """Return the figures of a fit by name."""
    makers: Mapping[str, Callable[[PlantFit], list[Panel]]] = {
        "fit": data_panels, "residuals": residual_panels, "step": step_panels, "bode": bode_panels,
    }  # fmt: skip

    def maker(make: "Callable[[PlantFit], list[Panel]]") -> Callable[[], Figure]:
        return lambda: figure_of(make(fit), 2, HEIGHT, titled=True)

    return {name: maker(make) for name, make in makers.items()}


def _joined(parts: Sequence[Array], shifted: bool = False) -> Array:
    """Return series one after the other with gaps between; shifted: as times that go on."""
    out, end = [], 0.0
    for part in parts:
        every = max(1, len(part) // MAX_POINTS)
        out += [part[::every] + end, np.array([np.nan])]
        end += float(part[-1]) if shifted else 0.0
    return np.concatenate(out[:-1])
