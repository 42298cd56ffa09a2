"""Bounds of metrics, so that a failed flight has a finite cost."""

from collections.abc import Iterable
from math import isfinite

from objectives.flown_system import FlownSystem
from objectives.metrics import MetricAddress
from plant.errors import InputError


def check_bounds(system: FlownSystem, metrics: Iterable[MetricAddress]) -> None:
    """Refuse metrics whose cost of a failure would be infinite: an error without a limit, a command without a range."""
    bounds = system.metric_limits()
    for metric in metrics:
        for axis in metric.axes:
            if not isfinite(bounds.error(axis)):
                raise _without_bound(system, metric, axis)
        if metric.metric.name in ("travel", "effort", "command_peak", "noise") and not isfinite(bounds.travel):
            raise InputError(
                f"'{metric}' judges commands, and an input has no range; write an [[actuator]] with low and high",
                key="actuator",
            )


def _without_bound(system: FlownSystem, metric: MetricAddress, axis: str) -> InputError:
    """Return the error of a metric whose axis has no bound."""
    given, size = f"'{metric}' judges {axis}, which has no", "from which on a flight has failed"
    if axis in system.laws:
        message = f"{given} lost_beyond; write lost_beyond = ..., the |error| {size}"
        return InputError(message, key=f"channel.{axis}.lost_beyond")
    return InputError(
        f"{given} limit; write [plant] lost_beyond = {{ {axis} = ... }}, the |value| {size}"
        f"{', or an [[actuator]] of that name with low and high' if axis in system.signals else ''}",
        key=f"plant.lost_beyond.{axis}",
    )
