"""Events of a flight whose probability is estimated: a metric beyond a limit, or the loss of the flight.

An event has demand over capacity of each of its modes and happens where one of them reaches 1. A lost flight is beyond every
limit of a metric, because its metrics cost more than those of any completed flight (`objectives.metrics.evaluate`).
"""

import re
from dataclasses import dataclass
from math import isfinite, radians
from typing import Any, Protocol

import numpy as np

from objectives.failure_modes import failure_demands
from objectives.flown_system import FlownSystem, Scenario
from objectives.metrics import MetricAddress, parse
from objectives.metrics.columns import unpack
from objectives.own_meters import check_on_flights, metering
from objectives.problem import STATUS_ROW, score_flights
from plant.backends.flyer import result_parts
from plant.errors import InputError
from plant.records import size
from plant.status import Status
from tuner.study.metric_bounds import check_bounds

FAILURE = "failure"
KEY = "--event"
FORM = re.compile(r"\s*([A-Za-z_][\w.]*)\s*>=?\s*(\S+)\s*(\S.*?)?\s*")
DEGREES = "deg"


class Event(Protocol):
    """An event of flights of a system through a scenario.

    Attributes:
        text: Text as it is written.
        metric: Metric whose exceedance it is, None for the loss of a flight.
        limit: Limit of the metric in its unit; of a loss 1, the demand over the capacity.
        modes: Names of its modes.
        system: With the accumulators that it needs.

    """

    @property
    def text(self) -> str: ...  # noqa: D102
    @property
    def metric(self) -> MetricAddress | None: ...  # noqa: D102
    @property
    def limit(self) -> float: ...  # noqa: D102
    @property
    def modes(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def system(self) -> FlownSystem: ...  # noqa: D102

    def demands(self, results: np.ndarray) -> np.ndarray:
        """Return demand over capacity (flights, modes) of results (flights, rows)."""
        ...


@dataclass(frozen=True)
class Exceedance:
    """A metric beyond a limit, in its unit."""

    text: str
    metric: MetricAddress
    limit: float
    system: FlownSystem
    spec: Scenario
    targets: Any

    @property
    def modes(self) -> tuple[str, ...]:
        """The metric alone."""
        return (str(self.metric),)

    def demands(self, results: np.ndarray) -> np.ndarray:
        """Return the metric over its limit."""
        scores, _ = score_flights(self.system, [self.metric], results, self.spec, self.targets)
        return scores.T / self.limit


@dataclass(frozen=True)
class Loss:
    """The loss of a flight, by its failure modes."""

    system: FlownSystem
    spec: Scenario
    text: str = FAILURE
    metric: None = None
    limit: float = 1.0

    @property
    def modes(self) -> tuple[str, ...]:
        """Names of the failure modes."""
        return tuple(mode.name for mode in self.system.failure_modes)

    def demands(self, results: np.ndarray) -> np.ndarray:
        """Return the demands of the failure modes."""
        meters, status, end = result_parts(results)
        duration = self.spec.steps(self.system.timing) * self.system.timing.control_period
        record = unpack(self.system.loop.Meters, meters)
        return failure_demands(self.system.failure_modes, record, status, 1.0 - end / duration)


def read_event(text: str, system: FlownSystem, spec: Scenario) -> Event:
    """Return the event that a text describes; InputError where flights of the scenario have none such."""
    if text.strip() == FAILURE:
        needed = [mode.metric for mode in system.failure_modes if mode.metric is not None]
        return Loss(metering(system, needed), spec)
    form = FORM.fullmatch(text)
    if form is None:
        raise InputError(f"given '{text}'; write METRIC > NUMBER, such as \"peak.position > 3\", or {FAILURE}", key=KEY)
    metric = parse(form[1], system.axes)
    _check_metric(metric, system, spec)
    limit = _in_unit(form[2], form[3] or "", metric)
    metered = metering(system, [metric])
    event = Exceedance(text.strip(), metric, limit, metered, spec, metered.targets(spec))
    largest = _largest(event)
    if limit >= largest:
        raise InputError(
            f"given '{text.strip()}'; {metric} of a flight that is not lost is at most {largest:.6g}: take a smaller limit, or "
            f"{FAILURE}",
            key=KEY,
        )
    return event


def _check_metric(metric: MetricAddress, system: FlownSystem, spec: Scenario) -> None:
    if metric.metric.is_binary:
        advice = f"write {FAILURE} alone" if metric.metric.name == FAILURE else "take a metric that grows"
        raise InputError(f"'{metric}' is 0 or 1, which does not show how near a flight came; {advice}", key=KEY)
    check_on_flights(metric, system, spec)
    check_bounds(system, [metric])


def _in_unit(number: str, unit: str, metric: MetricAddress) -> float:
    """Return a limit in the unit of its metric; degrees may represent radians."""
    try:
        limit = float(number)
    except ValueError:
        limit = 0.0
    if not (isfinite(limit) and limit > 0.0):
        raise InputError(f"given '{number}' for {metric}; allowed: a number above 0", key=KEY)
    allowed = {"": 1.0, metric.unit: 1.0} | ({DEGREES: radians(1.0)} if metric.unit == "rad" else {})
    if unit not in allowed:
        names = " or ".join(name for name in allowed if name)
        raise InputError(f"given the unit '{unit}'; the unit of {metric} is {names}", key=KEY)
    return limit * allowed[unit]


def _largest(event: Exceedance) -> float:
    """Return the bound of the metric: the cost of a flight that is lost as it begins is twice that."""
    results = np.zeros((1, size(event.system.loop.Meters) + 2))
    results[..., STATUS_ROW] = Status.LOST.code
    scores, _ = score_flights(event.system, [event.metric], results, event.spec, event.targets)
    return float(scores[0, 0]) / (2.0 if event.metric.metric.graded else 1.0)
