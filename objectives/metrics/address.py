"""The address of a metric in a study: "itae.roll", "itae.attitude", "travel".

A group joins axes of one unit by the metric's own rule; m and rad are never added.
"""

from dataclasses import dataclass

import numpy as np

from objectives.metrics.metric import Metric
from objectives.metrics.registry import METRICS
from plant.errors import InputError, UnknownNameError
from plant.targets import Target, Targets

AXES: dict[str, tuple[str, ...]] = {
    "x": ("x",),
    "y": ("y",),
    "z": ("z",),
    "roll": ("roll",),
    "pitch": ("pitch",),
    "yaw": ("yaw",),
    "position": ("x", "y", "z"),
    "horizontal": ("x", "y"),
    "attitude": ("roll", "pitch", "yaw"),
    "tilt": ("roll", "pitch"),
}
"""The axes behind every name that may follow the dot of an address."""

UNITS = {"x": "m", "y": "m", "z": "m", "roll": "rad", "pitch": "rad", "yaw": "rad"}


@dataclass(frozen=True)
class MetricAddress:
    """One metric of certain axes; axes is empty for a metric of the whole flight. Printed, it is the address again."""

    text: str
    metric: Metric
    axes: tuple[str, ...]

    def __str__(self) -> str:
        return self.text

    @property
    def unit(self) -> str:
        """SI unit of the value, "1" for none: "rad^2 s"."""
        return self.metric.unit.format(UNITS[self.axes[0]] if self.axes else "")


def addresses_of(metric: Metric) -> tuple[str, ...]:
    """Return every valid address of one metric."""
    return (metric.name,) if metric.scope == "flight" else tuple(f"{metric.name}.{axes}" for axes in AXES)


def all_addresses() -> tuple[str, ...]:
    """Return every valid address."""
    return tuple(address for metric in METRICS.values() for address in addresses_of(metric))


def parse(address: str) -> MetricAddress:
    """Return what an address stands for; UnknownNameError, with the nearest valid name, if it stands for nothing."""
    name, _, axes = address.partition(".")
    metric = METRICS.find(name)
    if address not in addresses_of(metric):
        raise UnknownNameError("metric address", address, addresses_of(metric))
    return MetricAddress(address, metric, AXES[axes] if axes else ())


def check(address: MetricAddress, targets: Targets, duration: float) -> None:
    """Raise InputError where the metric has no meaning on flights with these targets and this duration [s].

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
