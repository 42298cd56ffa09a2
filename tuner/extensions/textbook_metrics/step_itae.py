"""ITAE of a step as textbooks print it: time counts from the step, and nothing is divided.

D. Graham, R. C. Lathrop, "The synthesis of optimum transient response: criteria and standard forms", Trans. AIEE, part II,
vol. 72, no. 5, 1953.
"""

from typing import Any, NamedTuple

import numpy as np

from objectives.meters import since
from objectives.metrics.metric import Accumulator, AxisView, Metric
from plant.primitives import absolute
from plant.sample import AxisSample, Target


class WeightedError(NamedTuple):
    """total: h sum (t - t0)|e| from the time t0 of the step [u s2]."""

    total: float


def start(sample: AxisSample, target: Target) -> WeightedError:  # noqa: ARG001
    """Begin without an error."""
    return WeightedError(0.0)


def update(state: WeightedError, sample: AxisSample, target: Target, t: float, h: float) -> WeightedError:
    """Add the error at one more instant."""
    weighted = h * (t - target.time) * absolute(sample.reference - sample.actual)
    return WeightedError(state.total + since(target.time, t, h, weighted, 0.0))


def _largest(view: AxisView) -> Any:
    """Return the value of the largest error at all instants."""
    return 0.5 * view.limit * np.maximum(view.context.duration - np.asarray(view.target.time), view.context.h) ** 2


METRIC = Metric(
    name="step_itae",
    symbol="ITAE",
    title="error after the step (ITAE)",
    unit="{} s^2",
    scope="axis",
    definition="integral of t|e|, t from the step, not normalized: the ITAE of textbooks",
    value=lambda view: view.accumulated.total,
    bound=_largest,
    window="time",
    accumulator=Accumulator(WeightedError, start, update),
)
