"""The system under study, and the batches of flights that it makes."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

from objectives import meters
from objectives.metrics import MetricAddress, MetricLimits
from objectives.metrics.address import CASCADE, Axes
from objectives.own_meters import code_of, with_accumulators
from plant.backends.flyer import FlightInputs, Flyer
from plant.backends.identity import identity
from plant.cascade import Cascade
from plant.closed_loop import Limits, close_loop
from plant.fittings import Fittings, fittings
from plant.gains import GainAddress, gain_addresses
from plant.loop import ClosedLoop, MeterModel, Timing
from plant.nominal import Nominal
from plant.origin import origins
from plant.records import flatten
from plant.scenarios import ScenarioSpec, sample_scenarios
from plant.targets import Targets
from plant.vehicle import Vehicle


@dataclass(frozen=True)
class System:
    """The closed loop under study: vehicle, cascade bound to its laws, the controller's knowledge, limits and timing.

    metered: metrics whose own accumulators run with every flight.
    """

    vehicle: Vehicle
    cascade: Cascade
    nominal: Nominal
    limits: Limits
    timing: Timing
    metered: tuple[MetricAddress, ...] = ()

    @cached_property
    def loop(self) -> ClosedLoop:
        """The closed loop with the meters of this package, and those of `metered`."""
        return close_loop(self.cascade, self.meter, self.fitted)

    @cached_property
    def meter(self) -> MeterModel:
        """The meters that judge its flights."""
        return with_accumulators(MeterModel(meters.Meters, meters.start, meters.update), self.metered)

    @property
    def fitted(self) -> Fittings:
        """The fittings of its vehicle and its controller."""
        return fittings(self.vehicle, self.timing.control_period, self.nominal.harmonics)

    def flyer(self, threads: int | None = None) -> Flyer:
        """Return what flies it: the compiled lanes on so many threads, by default one for each core."""
        return Flyer(self.loop, self.limits, self.timing, threads)

    @property
    def arithmetic(self) -> str:
        """Name of the bits that its flights have on this machine, see `objectives.engine`."""
        return Flyer.arithmetic

    @property
    def gains(self) -> tuple[GainAddress, ...]:
        """All gains in the column order of a gains row."""
        return gain_addresses(self.cascade)

    @property
    def axes(self) -> Axes:
        """The axes that its flights are judged on."""
        return CASCADE

    def sample(self, spec: ScenarioSpec, root: int, stream: str, indices: Iterable[int]) -> FlightInputs:
        """Draw scenarios of a stream."""
        return sample_scenarios(spec, self.vehicle, self.timing, root, stream, indices)

    def targets(self, spec: ScenarioSpec) -> Targets:
        """Return what the flights of a scenario are measured against."""
        return spec.targets(self.timing)

    def content(self, spec: ScenarioSpec) -> dict[str, Any]:
        """Return all that decides its flights through a scenario but seeds and gains, as JSON-able data."""
        reference = asdict(spec.reference)
        # What is in a waypoint file decides, not where it lies.
        reference.pop("path", None)
        laws = origins((self.cascade.position, self.cascade.attitude))
        own = laws | origins([type(spec.reference)], "kind")
        return {
            **({"code": own} if own else {}),
            **({"meters": identity(code_of(self.metered))} if self.metered else {}),
            "laws": [self.cascade.position.name, self.cascade.attitude.name],
            **({} if self.cascade.position_every == 1 else {"position_every": self.cascade.position_every}),
            "numbers": [flatten(part) for part in (self.vehicle, self.nominal, self.limits, self.timing)],
            "scenario": {**asdict(spec), "reference": {**reference, "kind": spec.reference.kind}},
        }

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
