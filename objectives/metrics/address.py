"""The address of a metric in a study: "itae.roll", "itae.attitude", "travel".

A group joins axes of one unit by the metric's own rule; m and rad are never added.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from objectives.metrics.metric import Metric
from objectives.metrics.registry import METRICS
from plant.errors import InputError, check_name
from plant.quadrotor.cascade import ATTITUDE_AXES, POSITION_AXES
from plant.quadrotor.gains import GROUPS
from plant.sample import Target


@dataclass(frozen=True)
class Axes:
    """Axes that flights are judged on: their units, and the groups that may follow the dot of an address."""

    units: Mapping[str, str]
    groups: Mapping[str, tuple[str, ...]]


UNITS: dict[str, str] = dict.fromkeys(POSITION_AXES, "m") | dict.fromkeys(ATTITUDE_AXES, "rad")
CASCADE = Axes(UNITS, GROUPS)
"""The axes of a quadrotor."""


@dataclass(frozen=True)
class MetricAddress:
    """One metric of certain axes; axes is empty for a metric of the whole flight. Printed, it is the address again."""

    text: str
    metric: Metric
    axes: tuple[str, ...]
    axis_unit: str = ""

    def __str__(self) -> str:
        return self.text

    @property
    def unit(self) -> str:
        """SI unit of the value, "1" for none: "rad^2 s"."""
        return self.metric.unit.format(self.axis_unit)


def addresses_of(metric: Metric, axes: Axes = CASCADE) -> tuple[str, ...]:
    """Return every valid address of one metric."""
    return (metric.name,) if metric.scope == "flight" else tuple(f"{metric.name}.{group}" for group in axes.groups)


def all_addresses(axes: Axes = CASCADE) -> tuple[str, ...]:
    """Return every valid address."""
    return tuple(address for metric in METRICS.values() for address in addresses_of(metric, axes))


def parse(address: str, axes: Axes = CASCADE) -> MetricAddress:
    """Return the metric and axes of an address; UnknownNameError, with the nearest valid name, for none."""
    name, _, group = address.partition(".")
    metric = METRICS.find(name)
    valid = addresses_of(metric, axes)
    check_name("metric address", address, valid)
    judged = axes.groups[group] if group else ()
    return MetricAddress(address, metric, judged, axes.units[judged[0]] if judged else "")


def check(address: MetricAddress, targets: Any, duration: float) -> None:
    """Raise InputError for a metric without meaning at these targets and duration [s].

    To be called when a study is read: `evaluate` gives such metrics defined but empty values instead.
    """
    judged: list[tuple[str, Target]] = [(axis, getattr(targets, axis)) for axis in address.axes]
    if address.metric.needs_step:
        judged = [(axis, target) for axis, target in judged if np.any(target.start != target.final)]
        if not judged:
            raise InputError(
                f"'{address}' needs a step, and no axis of it makes one; use 'peak' or 'settling', or add a step"
            )
    if address.metric.window:
        for axis, target in judged:
            _check_window(address, axis, address.metric.window, getattr(target, address.metric.window), duration)


def _check_window(address: MetricAddress, axis: str, window: str, begin: float, duration: float) -> None:
    if np.any(np.asarray(begin) >= duration):
        raise InputError(
            f"'{address}' looks at {axis} from {window} = {begin} s on, but the flight ends at {duration} s; "
            "let the flight last longer or the window begin earlier"
        )
