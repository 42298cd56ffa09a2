"""The system under study, and the batches of flights that it makes."""

from dataclasses import dataclass
from functools import cached_property

from objectives import meters
from objectives.metrics import MetricLimits
from plant.cascade import Cascade
from plant.closed_loop import Limits, close_loop
from plant.loop import ClosedLoop, MeterModel, Timing
from plant.nominal import Nominal
from plant.scenarios import ScenarioSpec
from plant.vehicle import Vehicle


@dataclass(frozen=True)
class System:
    """The closed loop under study: vehicle, cascade bound to its laws, the controller's knowledge, limits and timing."""

    vehicle: Vehicle
    cascade: Cascade
    nominal: Nominal
    limits: Limits
    timing: Timing

    @cached_property
    def loop(self) -> ClosedLoop:
        """The closed loop with the meters of this package."""
        return close_loop(self.cascade, MeterModel(meters.Meters, meters.start, meters.update))

    def metric_limits(self) -> MetricLimits:
        """Return what no completed flight exceeds."""
        return MetricLimits(self.limits.position, self.nominal.thrust_max / self.nominal.hover)


@dataclass(frozen=True)
class FlightBatch:
    """The flights of one scenario: which stream they are drawn from, and those from `start` to before `count`."""

    spec: ScenarioSpec
    stream: str
    count: int
    start: int = 0
