"""A plant of the user's own under study: its loops, its controller's model, its limits and its timing."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import inf, isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from objectives.failure_modes import FailureMode, diverged, largest_error
from objectives.flown_system import NOT_FINITE
from objectives.metrics.address import Axes, MetricAddress
from objectives.named_channels import channels_by_name, channels_of
from objectives.own_meters import with_accumulators
from objectives.plant_meters import meters_of
from plant.backends.flyer import FlightInputs, Flyer
from plant.backends.identity import identity
from plant.errors import InputError
from plant.laws.channel import Channel as Knowledge
from plant.laws.law import GainInfo, Law
from plant.loop import Timing
from plant.model.closing import PlantLoop, close_plant
from plant.model.controller import Range
from plant.model.modes import accurate_steps, accurate_timing, check_plant_step, poles_at_rest
from plant.model.observer import Observer
from plant.model.plan import Actuator, Channel, LoopPlan, WatchedSignal, plan_loop
from plant.model.plant_model import PlantModel, PlantRecords, plant_from
from plant.model.scenario import PlantScenario, draw_plant_scenarios
from plant.model.units import gain_unit
from plant.own_code import HAVE_RUN, OwnCode
from plant.quadrotor.gains import GainAddress
from plant.records import flatten, pack, paths, size
from plant.seeds import RandomSource, source_of
from plant.status import Status

if TYPE_CHECKING:
    from plant.model.slope import Slope


@dataclass(frozen=True)
class PlantBounds:
    """Bounds of the flights of a plant, see `objectives.metrics.context.Bounds`.

    errors: largest |e| of each channel and |value| of each other signal, in its unit. low, high: range of inputs in their scales.
    h: control period [s].
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
class PlantParts:
    """The parts of the system of a plant of the user's own.

    Args:
        make: Makes the plant: of its numbers, or of its file, which the process that calls it has run.
        channels: Fields of each, laws by their names.
        actuators: Actuators of its inputs.
        parameters: Nominal ones, in the order of the record.
        timing: Its periods.
        watched: Signals with meters of their own.
        observer: Estimates of outputs without a sensor.
    """

    make: Callable[[], PlantModel]
    channels: tuple[dict[str, Any], ...]
    actuators: tuple[Actuator, ...]
    parameters: tuple[float, ...]
    timing: Timing
    watched: tuple[WatchedSignal, ...] = ()
    observer: Observer | None = None

    def system(self) -> "PlantSystem":
        """Build the system."""
        plant = self.make()
        plan = plan_loop(plant, channels_of(self.channels), self.actuators, self.watched, self.observer)
        return PlantSystem(plant, plan, pack(plant.Parameters, list(self.parameters)), self.timing)


def plant_of_code(digest: str, name: str) -> PlantModel:
    """Return the plant of a file that this process has run."""
    code = HAVE_RUN[digest]
    return plant_from(code.names, name, str(code.file))


@dataclass(frozen=True)
class PlantSystem:
    """A plant with the plan of its loops, nominal parameters and timing.

    `objectives.problem` flies it.
    metered: metrics whose own accumulators run with every flight.
    """

    order = 4
    has_shared_laws = False
    has_equations = True
    command = "control.command"
    traced = ("body.shown", "control.command", "control.commands")

    plant: PlantRecords
    plan: LoopPlan
    parameters: Any
    timing: Timing
    metered: tuple[MetricAddress, ...] = ()

    @cached_property
    def loop(self) -> PlantLoop:
        """The closed loop with the meters of its channels and of `metered`."""
        meters = with_accumulators(meters_of(self.plan), self.metered, self.plan.scales)
        return close_plant(self.plant, self.plan, meters, self.timing.control_period)

    @cached_property
    def nominal(self) -> Any:
        """The controller's knowledge: gain of every channel, whether it measures a rate, limits of every command."""
        kind = self.loop.records.Nominal
        channels = [Knowledge(each.b0, 0.0 if each.rate_output else 1.0) for each in self.plan.channels]
        commands = [Range(each.low, each.high, inf) for each in self.plan.channels]
        h = self.timing.control_period
        inputs = [Range(each.low, each.high, each.rate * h) for each in self.plan.actuators]
        parts = kind.__annotations__
        estimator = [pack(parts["observer"], self.plan.observer.numbers)] if self.plan.observer else []
        return kind(*channels, parts["commands"](*commands), parts["inputs"](*inputs), *estimator)

    def flyer(self, threads: int | None = None) -> Any:
        """Return its flyer: the compiled lanes on so many threads, by default one for each core."""
        return Flyer(self.loop, self.limits, self.timing, threads)

    @property
    def arithmetic(self) -> str:
        """Name of the arithmetic of its flights on this machine, see `objectives.engine`."""
        return Flyer.arithmetic

    @property
    def limits(self) -> Any:
        """Largest |error| of every channel and watched signal, in its unit."""
        return self.loop.records.Limits(*self.plan.limits.values())

    @property
    def gains(self) -> tuple[GainAddress, ...]:
        """All gains in the order of a gains row, in channel units."""
        gains = list[GainAddress]()
        for channel in self.plan.channels:
            for info in channel.law.gains:
                written = self._in_units(info, channel)
                address = f"{channel.name}.{info.name.rstrip('_')}"
                span = written.span("attitude")
                gains.append(GainAddress(address, len(gains), channel.name, "attitude", written, span))
        return tuple(gains)

    def _in_units(self, info: GainInfo, channel: Channel) -> GainInfo:
        """Return a gain in the units of its channel: those of the command where b0 is 1, else accelerations of the output."""
        unit = self.plant.unit(f"Output.{channel.output}")
        if info.integrals is None or abs(channel.b0) != 1.0:
            return replace(info, unit=info.unit.replace("{y}", unit))
        commanded = gain_unit(self.plan.command_unit(self.plant, channel), unit, info.integrals)
        return replace(info, unit=commanded, meaning=info.meaning.replace("acceleration", "command"))

    @property
    def axes(self) -> Axes:
        """All channels, outputs and inputs as axes of the metrics."""
        channels = {each.name: self.plant.unit(f"Output.{each.output}") for each in self.plan.channels}
        signals = {name: self.plant.unit(f"{record}.{name}") for name, record in self.plant.signals.items()}
        units = channels | {name: unit for name, unit in signals.items() if name not in channels}
        return Axes(units, {name: (name,) for name in units})

    @property
    def watched(self) -> tuple[str, ...]:
        """Signals that no channel controls, with meters of their own."""
        return tuple(signal.name for signal in self.plan.watched)

    def watching(self, names: Iterable[str]) -> "PlantSystem":
        """Return the system with meters of these signals too."""
        added = tuple(dict.fromkeys(name for name in names if name not in self.plan.judged))
        if not added:
            return self
        watched = [WatchedSignal(name, self.plant.signals[name]) for name in added]
        return replace(self, plan=self.plan.watching(watched))

    def slope(self, parameters: Any) -> "Slope":
        """Return the body at rest, and its derivative a period later.

        The plant has these parameters; the derivative is by body and commands.
        """
        # Here, because a study that asks for no margins needs no CasADi.
        from plant.model.slope import exact_slope

        return exact_slope(self.loop, self.timing, parameters)

    def flown_slope(self, parameters: Any) -> "Slope":
        """Return the slope as the steps of flights have it."""
        from plant.model.slope import flown_slope

        return flown_slope(self.loop, self.timing, parameters)

    @property
    def laws(self) -> dict[str, Law]:
        """The law of each channel."""
        return {channel.name: channel.law for channel in self.plan.channels}

    @property
    def signals(self) -> dict[str, str]:
        """Units of channels, then of watched outputs, then of inputs."""
        units = self.axes.units
        shown = (*self.plan.names, *self._watched_outputs)
        inputs = {name: self.plant.unit(f"Input.{name}") for name in paths(self.plant.Input)}
        return {**{name: units[name] for name in shown}, **inputs}

    @property
    def _watched_outputs(self) -> list[str]:
        return [signal.name for signal in self.plan.watched if signal.record == "Output"]

    def responses(self, trace: np.ndarray, references: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return signals and their references (scenarios, instants, signals), see `FlownSystem`."""
        plan, n, m = self.plan, size(self.plant.Output), size(self.plant.Input)
        shown, inputs, commands = np.split(trace, (n, n + m), axis=-1)
        outputs = paths(self.plant.Output)
        actual = [shown[..., outputs.index(channel.output)] for channel in plan.channels]
        reference = [
            commands[..., plan.names.index(plan.commanded[name])]
            if name in plan.commanded
            else np.broadcast_to(references[:, 3 * i], actual[i].shape)
            for i, name in enumerate(plan.names)
        ]
        others = [*(shown[..., outputs.index(name)] for name in self._watched_outputs), *np.moveaxis(inputs, -1, 0)]
        nothing = np.full_like(actual[0], np.nan)
        return (
            np.stack([*actual, *others], axis=-1),
            np.stack([*reference, *[nothing] * len(others)], axis=-1),
        )

    @property
    def command_scales(self) -> np.ndarray:
        """The size that the command of each input is counted in."""
        return np.array(list(self.plan.scales.values()))

    @property
    def failure_causes(self) -> dict[Status, tuple[str, str]]:
        """Cause of each failure, and the limit that it exceeds."""
        units = self.axes.units
        *others, last = [
            f"{limit:g} {units[name]} off in {name}" for name, limit in self.plan.limits.items() if isfinite(limit)
        ] or [""]
        errors = f"{', '.join(others)} or {last}" if others else last
        return {Status.LOST: ("error", errors), Status.NON_FINITE: NOT_FINITE}

    @property
    def failure_modes(self) -> tuple[FailureMode, ...]:
        """The error of what has a limit, over that."""
        return (
            *[
                FailureMode(name, Status.LOST, partial(largest_error, (name,), limit))
                for name, limit in self.plan.limits.items()
                if isfinite(limit)
            ],
            diverged(self.plan.names),
        )

    @property
    def disturbances(self) -> dict[str, str]:
        """The fields of the plant's Disturbance with their units."""
        return {name: self.plant.unit(f"Disturbance.{name}") for name in paths(self.plant.Disturbance)}

    @property
    def equations(self) -> PlantModel:
        """The plant, as equations that can be evaluated anywhere."""
        assert isinstance(self.plant, PlantModel), self.plant.name
        return self.plant

    @property
    def min_steps(self) -> int:
        """Fewest plant steps of a control period that are accurate at rest."""
        poles = poles_at_rest(self.equations, self.parameters, self.plan.actuators)
        return accurate_steps(self.timing.control_period * poles)

    def checked_timing(self, is_given: bool) -> Timing:
        """Return its periods; InputError with the key where the plant step is too long.

        is_given: somebody chose the plant step; else it is the longest that is accurate at rest.
        """
        poles = poles_at_rest(self.equations, self.parameters, self.plan.actuators)
        if not is_given:
            return accurate_timing(poles, self.timing.control_period)
        check_plant_step(poles, self.timing)
        return self.timing

    @property
    def own_code(self) -> OwnCode | None:
        """The file of the plant, None of one by its numbers; InputError where there is neither."""
        if self.equations.make is not None:
            return None
        derivative = self.equations.derivative
        code = next((each for each in HAVE_RUN.values() if each.names.get("derivative") is derivative), None)
        if code is None:
            raise InputError(
                "no file holds the code of this plant, so no worker can have it; write it to a file, or leave --dask out"
            )
        return code

    @property
    def parts(self) -> PlantParts:
        """Names and numbers from which another process builds it; InputError as `own_code`."""
        code = self.own_code
        make = self.equations.make if code is None else partial(plant_of_code, code.digest, self.plant.name)
        assert make is not None
        parameters = tuple(float(value) for value in flatten(self.parameters))
        channels = channels_by_name(self.plan.channels)
        plan = self.plan
        return PlantParts(make, channels, plan.actuators, parameters, self.timing, plan.watched, plan.observer)

    def with_own_plant(
        self,
        drawn: FlightInputs,
        owner: "PlantSystem",
        spec: PlantScenario,
        root: int,
        stream: str,
        indices: Iterable[int],
    ) -> FlightInputs:
        """Return another system's scenarios with references of this system's channels.

        Both systems are of the same plant.
        """
        # Draws have the names of what they are of, so they are the same whatever channels there are.
        return drawn if self.plan.judged == owner.plan.judged else self.sample(spec, root, stream, indices)

    def metric_limits(self) -> PlantBounds:
        """Return the bounds of a completed flight."""
        sizes = [actuator.size for actuator in self.plan.actuators]
        pairs = list(zip(self.plan.actuators, sizes, strict=True))
        ranges = {each.name: max(abs(each.low), abs(each.high)) for each in self.plan.actuators}
        others = {name: ranges[name] if record == "Input" else inf for name, record in self.plant.signals.items()}
        return PlantBounds(
            {
                **others,
                **{name: limit for name, limit in self.plan.limits.items() if isfinite(limit) or name not in others},
            },
            tuple(actuator.low / size for actuator, size in pairs),
            tuple(actuator.high / size for actuator, size in pairs),
        )

    def sample(self, spec: PlantScenario, root: int, stream: str, indices: Iterable[int]) -> FlightInputs:
        """Draw scenarios of a stream."""
        return self.draw(spec, source_of(root, f"{stream}/{spec.name}"), indices)

    def draw(self, spec: PlantScenario, source: RandomSource, indices: Iterable[int]) -> FlightInputs:
        """Draw scenarios from a source of random numbers."""
        return draw_plant_scenarios(spec, self.loop, self.parameters, self.timing, source, indices)

    def names_of_draws(self, spec: PlantScenario) -> dict[str, tuple[str, ...]]:
        """Return the names of the parameters and of the sensors' biases."""
        biases = {f"sensor/{name}": ("bias",) for name in spec.sensors}
        joint = [f"joint {i + 1}" for i in range(len(spec.joint_spread))]
        return {"plant": (*paths(self.plant.Parameters), *joint), **biases}

    def targets(self, spec: PlantScenario) -> Any:
        """Return the targets of the flights of a scenario."""
        return spec.targets_of(self.loop, self.parameters)

    def content(self, spec: PlantScenario) -> dict[str, Any]:
        """Return all that determines its flights through a scenario, as JSON-able data.

        Seeds and gains are not part of it.
        """
        numbers = [flatten(part) for part in (self.parameters, self.nominal, self.limits, self.timing)]
        signals = [
            sorted((name, repr(each)) for name, each in part.items()) for part in (spec.references, spec.disturbances)
        ]
        rest = [
            sorted((name, repr(each)) for name, each in part.items()) for part in (spec.sensors, spec.spread, spec.band)
        ]
        rest += [sorted((name, repr(each)) for name, each in part.items()) for part in spec.joint_spread]
        return {
            "plant": identity(self.loop),
            "numbers": [[value if isfinite(value) else repr(value) for value in part] for part in numbers],
            "scenario": [spec.name, spec.duration, signals, rest, spec.settling, spec.recovery_from, spec.steady_share],
        }
