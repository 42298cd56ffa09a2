"""Flies the meters, as plain Python floats, along signals whose metrics are known."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from objectives import meters as bundled
from objectives.metrics import COMPLETED, METRICS, FlightContext, MetricAddress, MetricLimits, Scores, parse
from objectives.metrics import evaluate as evaluate_rows
from objectives.own_meters import with_accumulators
from plant.loop import MeterModel
from plant.quadrotor.sample import Sample, Targets
from plant.records import paths
from plant.sample import AxisSample, Target
from plant.vectors import Rotors

AXES = ("x", "y", "z", "roll", "pitch", "yaw")
HOVER = Rotors(1.0, 1.0, 1.0, 1.0)
H = 0.004
LIMITS = MetricLimits(position_error=50.0, command_peak=3.0)
METERS = with_accumulators(
    MeterModel(bundled.Meters, bundled.start, bundled.update),
    [
        parse(name)
        for m in METRICS.values()
        for name in ([m.name] if m.scope == "flight" else [f"{m.name}.{axis}" for axis in AXES])
    ],
)
"""The meters of every flight and those that metrics bring along."""
WIDTH = len(paths(METERS.Meters))

Signal = Callable[[float], tuple[float, float]]
"""Reference and actual value at time t."""


def target(
    start: float = 0.0,
    final: float = 0.0,
    time: float = 0.0,
    band: float = 0.05,
    recovery_from: float = 0.0,
    recovery_band: float = 0.05,
    steady_from: float = 0.0,
) -> Target:
    """Return a target; by default the axis makes no step."""
    return Target(start, final, time, band, recovery_from, recovery_band, steady_from)


def targets(**axes: Target) -> Targets:
    """Return targets of six axes; those not named make no step."""
    return Targets(*(axes.get(name, target()) for name in AXES))


def flat(values: tuple[Any, ...]) -> list[float]:
    """Return the scalars of nested tuples, depth first."""
    return [x for value in values for x in (flat(value) if isinstance(value, tuple) else [value])]


def fly(
    signals: Mapping[str, Signal],
    aims: Targets,
    duration: float,
    h: float = H,
    command: Callable[[int], Rotors] = lambda k: HOVER,
    saturated: Callable[[int], float] = lambda k: 0.0,
) -> Any:
    """Return the final meters; an axis without a signal stands still on its reference 0."""

    def sample(k: int) -> Sample:
        x, y, z, roll, pitch, yaw = (
            AxisSample(*signals[name](k * h)) if name in signals else AxisSample(0.0, 0.0) for name in AXES
        )
        return Sample(k * h, x, y, z, roll, pitch, yaw, command(k), command(k - 1), saturated(k))

    meters = METERS.start(sample(0), aims)
    for k in range(round(duration / h)):
        meters = METERS.update(meters, sample(k), aims, h)
    return meters


def rows(*meters: Any) -> NDArray[np.float64]:
    """Return the meters of flights as an array (flights, columns)."""
    array = np.array([flat(m) for m in meters])
    assert array.shape[1] == WIDTH
    return array


def evaluate(addresses: Sequence[MetricAddress], meters: NDArray[np.float64], context: FlightContext) -> Scores:
    """Return the scores of rows of `METERS`."""
    return evaluate_rows(addresses, meters, context, METERS.Meters)


def completed(
    aims: Targets, duration: float, flights: tuple[int, ...] = (1,), h: float = H, limits: MetricLimits = LIMITS
) -> FlightContext:
    """Return the context of flights that all reached their end."""
    return FlightContext(duration, h, aims, np.full(flights, COMPLETED), np.full(flights, duration), limits)


def score(address: str, meters: Any, aims: Targets, duration: float, h: float = H) -> float:
    """Return one metric of one completed flight."""
    return float(scores(address, meters, aims, duration, h).values[0, 0])


def censored(address: str, meters: Any, aims: Targets, duration: float, h: float = H) -> bool:
    """Return whether one metric of one completed flight is censored."""
    return bool(scores(address, meters, aims, duration, h).censored[0, 0])


def scores(address: str, meters: Any, aims: Targets, duration: float, h: float = H) -> Scores:
    """Return the scores (1, 1) of one metric of one completed flight."""
    where: MetricAddress = parse(address)
    return evaluate([where], rows(meters), completed(aims, duration, h=h))
