"""A plant of the user's own under study: its loops, what its controller knows, its limits and its timing."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, isfinite
from typing import Any

from objectives.metrics.address import Axes, MetricAddress
from objectives.own_meters import with_accumulators
from objectives.plant_meters import meters_of
from plant.backends.flyer import FlightInputs, Flyer
from plant.backends.identity import identity
from plant.gains import GainAddress
from plant.laws.channel import Channel as Known
from plant.laws.law import GainInfo
from plant.loop import Timing
from plant.model.closing import PlantLoop, close_plant
from plant.model.controller import Range
from plant.model.plan import Channel, LoopPlan
from plant.model.plant_model import PlantRecords
from plant.model.scenario import PlantScenario, sample_plant_scenarios
from plant.model.units import gain_unit
from plant.records import flatten


@dataclass(frozen=True)
class PlantBounds:
    """Bounds of the flights of a plant, see `objectives.metrics.context.Bounds`.

    errors: largest |e| of each channel, in its unit; low, high: range of each input in its scale; h: control period [s].
    """

    errors: dict[str, float]
    low: tuple[float, ...]
    high: tuple[float, ...]

    @property
    def command_peak(self) -> float:
        """Largest |command| of any input."""
        return max(max(abs(a), abs(b)) for a, b in zip(self.low, self.high, strict=True))

    @property
    def travel(self) -> float:
        """All inputs from one end to the other."""
        return sum(high - low for low, high in zip(self.low, self.high, strict=True))

    @property
    def effort(self) -> float:
        """All inputs at the end that is further from 0."""
        return sum(max(abs(low), abs(high)) ** 2 for low, high in zip(self.low, self.high, strict=True))

    def error(self, axis: str) -> float:
        """Return the largest |e| of a channel."""
        return self.errors[axis]


@dataclass(frozen=True)
class PlantSystem:
    """A plant, the plan of its loops, its nominal parameters and its timing: what `objectives.problem` flies.

    metered: metrics whose own accumulators run with every flight.
    """

    plant: PlantRecords
    plan: LoopPlan
    parameters: Any
    timing: Timing
    metered: tuple[MetricAddress, ...] = ()

    @cached_property
    def loop(self) -> PlantLoop:
        """The closed loop with the meters of its channels, and those of `metered`."""
        meters = with_accumulators(meters_of(self.plan), self.metered, self.plan.scales)
        return close_plant(self.plant, self.plan, meters, self.timing.control_period)

    @cached_property
    def nominal(self) -> Any:
        """The controller's knowledge: gain of every channel, whether it measures a rate, limits of every command."""
        kind = self.loop.records.Nominal
        known = [Known(each.b0, 0.0 if each.rate_output else 1.0) for each in self.plan.channels]
        commands = [Range(each.low, each.high, inf) for each in self.plan.channels]
        h = self.timing.control_period
        inputs = [Range(each.low, each.high, each.rate * h) for each in self.plan.actuators]
        parts = kind.__annotations__
        return kind(*known, parts["commands"](*commands), parts["inputs"](*inputs))

    def flyer(self, threads: int | None = None) -> Any:
        """Return what flies it: the compiled lanes on so many threads, by default one for each core."""
        return Flyer(self.loop, self.limits, self.timing, threads)

    @property
    def arithmetic(self) -> str:
        """Name of the bits that its flights have on this machine, see `objectives.engine`."""
        return Flyer.arithmetic

    @property
    def limits(self) -> Any:
        """Largest |error| of every channel, in its unit."""
        return self.loop.records.Limits(*[channel.limit for channel in self.plan.channels])

    @property
    def gains(self) -> tuple[GainAddress, ...]:
        """All gains in the column order of a gains row, in the units of their channel."""
        found = []
        for channel in self.plan.channels:
            for info in channel.law.gains:
                written = self._in_units(info, channel)
                address = f"{channel.name}.{info.name.rstrip('_')}"
                span = written.span("attitude")
                found.append(GainAddress(address, len(found), channel.name, "attitude", written, span))
        return tuple(found)

    def _in_units(self, info: GainInfo, channel: Channel) -> GainInfo:
        """Return a gain in the units of its channel: those of the command where b0 is 1, else accelerations of the output."""
        unit = self.plant.unit(f"Output.{channel.output}")
        if info.integrals is None or abs(channel.b0) != 1.0:
            return replace(info, unit=info.unit.replace("{y}", unit))
        commanded = gain_unit(self.plan.command_unit(self.plant, channel), unit, info.integrals)
        return replace(info, unit=commanded, meaning=info.meaning.replace("acceleration", "command"))

    @property
    def axes(self) -> Axes:
        """The channels as axes that flights are judged on, each a group of its own."""
        units = {each.name: self.plant.unit(f"Output.{each.output}") for each in self.plan.channels}
        return Axes(units, {name: (name,) for name in units})

    def metric_limits(self) -> PlantBounds:
        """Return what no completed flight exceeds."""
        sizes = [actuator.size for actuator in self.plan.actuators]
        pairs = list(zip(self.plan.actuators, sizes, strict=True))
        return PlantBounds(
            {channel.name: channel.limit for channel in self.plan.channels},
            tuple(actuator.low / size for actuator, size in pairs),
            tuple(actuator.high / size for actuator, size in pairs),
        )

    def sample(self, spec: PlantScenario, root: int, stream: str, indices: Iterable[int]) -> FlightInputs:
        """Draw scenarios of a stream."""
        return sample_plant_scenarios(spec, self.loop, self.parameters, self.timing, root, stream, indices)

    def targets(self, spec: PlantScenario) -> Any:
        """Return what the flights of a scenario are measured against."""
        return spec.targets_of(self.loop, self.parameters)

    def content(self, spec: PlantScenario) -> dict[str, Any]:
        """Return all that decides its flights through a scenario but seeds and gains, as JSON-able data."""
        numbers = [flatten(part) for part in (self.parameters, self.nominal, self.limits, self.timing)]
        signals = [
            sorted((name, repr(each)) for name, each in part.items()) for part in (spec.references, spec.disturbances)
        ]
        rest = [
            sorted((name, repr(each)) for name, each in part.items()) for part in (spec.sensors, spec.spread, spec.band)
        ]
        return {
            "plant": identity(self.loop),
            "numbers": [[value if isfinite(value) else repr(value) for value in part] for part in numbers],
            "scenario": [spec.name, spec.duration, signals, rest, spec.settling, spec.recovery_from, spec.steady_share],
        }
