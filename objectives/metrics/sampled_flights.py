"""Sampled flights inside the limits, for checks of accumulators.

Signals of the axes are random, and the first flight jumps from one limit to the other at every instant: the worst case of a
bound.
"""

from collections.abc import Iterator
from functools import lru_cache
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from objectives import meters
from objectives.metrics.address import UNITS
from objectives.metrics.context import COMPLETED, FlightContext, MetricLimits
from objectives.metrics.metric import AxisView, FlightView
from objectives.metrics.over_inputs import ROTORS, over_inputs
from plant.backends import array
from plant.quadrotor.cascade import AXES
from plant.quadrotor.sample import Sample, Targets
from plant.records import flatten, pack

Array = NDArray[np.float64]


class Plan(NamedTuple):
    """Number of flights, length and control period [s], targets and limits."""

    flights: int
    duration: float
    period: float
    targets: Targets
    limits: MetricLimits


def sampled_views(metric: Any, plan: Plan) -> Iterator[AxisView | FlightView]:
    """Yield what a metric with an accumulator sees of the flights: one view of the whole, or one of each axis."""
    samples, leaves = _flown(plan)
    bundled: Any = pack(meters.Meters, [leaf.copy() for leaf in leaves])
    status, end = np.full(plan.flights, COMPLETED), np.full(plan.flights, plan.duration)
    context = FlightContext(plan.duration, plan.period, plan.targets, status, end, plan.limits)
    bind, h = array.rebinder(), plan.period
    accumulator = over_inputs(metric.accumulator, ROTORS)
    start, update = bind(accumulator.start), bind(accumulator.update)
    if metric.scope == "flight":
        accumulated = start(samples[0], plan.targets)
        for sample in samples:
            accumulated = update(accumulated, sample, plan.targets, h)
        yield FlightView(bundled, context, accumulated)
        return
    for axis in AXES:
        target = getattr(plan.targets, axis)
        accumulated = start(getattr(samples[0], axis), target)
        for sample in samples:
            accumulated = update(accumulated, getattr(sample, axis), target, sample.time, h)
        yield AxisView(getattr(bundled, axis), target, _limit(plan, axis), context, accumulated)


@lru_cache(maxsize=2)
def _flown(plan: Plan) -> tuple[tuple[Sample, ...], tuple[Array, ...]]:
    """Return the samples of a plan and the leaves of its meters.

    They are those of every metric, and three quarters of the time of its check. A metric may not write to the samples.
    """
    samples = tuple(_samples(plan))
    for sample in samples:
        for leaf in flatten(sample):
            if isinstance(leaf, np.ndarray):
                leaf.flags.writeable = False
    bind = array.rebinder()
    bundled = bind(meters.start)(samples[0], plan.targets)
    update = bind(meters.update)
    for sample in samples:
        bundled = update(bundled, sample, plan.targets, plan.period)
    return samples, tuple(np.asarray(leaf) for leaf in flatten(bundled))


def _limit(plan: Plan, axis: str) -> float:
    return plan.limits.position_error if UNITS[axis] == "m" else plan.limits.angle


def _samples(plan: Plan) -> Iterator[Sample]:
    """Yield what stands at every control instant, arrays over the flights."""
    rng = np.random.default_rng(7)
    command: Any = np.ones((4, plan.flights))
    for k in range(round(plan.duration / plan.period)):
        seen: Any = [_axis(plan, axis, k, rng) for axis in Sample._fields[1:7]]
        previous, command = command, _drawn(rng, plan.flights, k, 4) * plan.limits.command_peak
        yield pack(Sample, [k * plan.period, *chain(*seen), *command, *previous, 0.0])


def _axis(plan: Plan, axis: str, k: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """Return the final level as reference, and a value within the limit."""
    level = getattr(plan.targets, axis).final
    size = 2.0 * _drawn(rng, plan.flights, k) - 1.0
    return level + np.zeros(plan.flights), level - _limit(plan, axis) * size


def _drawn(rng: np.random.Generator, flights: int, k: int, *shape: int) -> Array:
    """Return numbers (..., flights) from 0 to 1; those of the first flight are 0 and 1 in turn."""
    drawn = rng.uniform(size=(*shape, flights))
    drawn[..., 0] = k % 2
    return drawn
