"""Overshoot past the final value of a response, as `stepinfo` counts it; a steady error does not hide it."""

from typing import Any, NamedTuple

import numpy as np

from objectives.meters import since
from objectives.metrics.metric import Accumulator, AxisView, Metric
from plant.primitives import maximum, sign
from plant.sample import AxisSample, Target

MIN_SHARE = 0.1
"""Smallest final value that the overshoot is divided by, as a share of the step."""


class Response(NamedTuple):
    """highest, last: furthest and last way from the level before the step towards the one after it [u]."""

    highest: float
    last: float


def start(sample: AxisSample, target: Target) -> Response:  # noqa: ARG001
    """Begin at the level before the step."""
    return Response(0.0, 0.0)


def update(state: Response, sample: AxisSample, target: Target, t: float, h: float) -> Response:
    """Take the response at one more instant."""
    way = (sample.actual - target.start) * sign(target.final - target.start)
    return Response(since(target.time, t, h, maximum(state.highest, way), state.highest), way)


def _per_cent(view: AxisView) -> Any:
    size, response = _size(view), view.accumulated
    divisor = np.maximum(response.last, MIN_SHARE * size)
    past = np.maximum(response.highest - response.last, 0.0)
    return np.where(size > 0.0, 100.0 * past / np.where(size > 0.0, divisor, 1.0), 0.0)


def _largest(view: AxisView) -> Any:
    """Return the value of the largest fall after a peak."""
    size = _size(view)
    return np.where(size > 0.0, 200.0 * view.limit / np.where(size > 0.0, MIN_SHARE * size, 1.0), 100.0)


def _size(view: AxisView) -> Any:
    return np.abs(np.asarray(view.target.final) - view.target.start)


METRIC = Metric(
    name="final_overshoot",
    symbol="M_p,f",
    title="overshoot past the final value",
    unit="%",
    scope="axis",
    definition="furthest excursion past the last value of the flight, in per cent of the way to it, at least a tenth of the step",
    value=_per_cent,
    bound=_largest,
    combine="max",
    window="time",
    needs_step=True,
    reaches_zero=True,
    accumulator=Accumulator(Response, start, update),
)
