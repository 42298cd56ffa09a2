"""A loop as data: which law closes which channel around which output, on which input, at which rate.

Channels whose command goes to an input of the plant are inner ones or single; one whose command goes to another channel is that
channel's set point (a cascade). Commands of several channels on one input add up.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from keyword import iskeyword
from math import inf, isfinite
from typing import NamedTuple

from plant.errors import InputError, UnknownNameError, check_name
from plant.laws.law import Law
from plant.model.observer import Observer
from plant.model.plant_model import PlantRecords
from plant.records import paths

# Longest delay of an input [control periods]: each is a number of the state. With 1024 a kernel compiles in 165 s instead of 12 s
# with 128, a flight takes 4 times as long, and margins of a candidate 4 s instead of 35 ms.
MAX_DELAY = 1024
# Names that stand beside those of the channels in the records of a loop and of its meters.
TAKEN = frozenset(
    ("time", "command", "previous", "saturated", "commands", "inputs", "travel", "effort", "command_peak")
)


@dataclass(frozen=True)
class Actuator:
    """An input's way to the plant: limited, slewed, delayed, then lagged.

    low, high: limits of the command [unit of the input]; rate: how fast a command may change [unit/s]; delay [s], whole control
    periods; lag: time constant of a first-order lag behind it [s], 0 for none. scale: the size that control activity is counted
    in, by default half the range, or 1 without limits.
    """

    name: str
    low: float = -inf
    high: float = inf
    rate: float = inf
    delay: float = 0.0
    lag: float = 0.0
    scale: float | None = None

    def __post_init__(self) -> None:
        if not self.low < self.high:
            raise InputError(f"given [{self.low}, {self.high}]; the lower end must be below the upper end", key="low")
        if not self.rate > 0.0:
            raise InputError(f"given {self.rate}; a rate must be positive", key="rate")
        for key in ("delay", "lag"):
            if not (isfinite(getattr(self, key)) and getattr(self, key) >= 0.0):
                raise InputError(f"given {getattr(self, key)} s; allowed: 0 s or more", key=key)
        if self.scale is not None and not (isfinite(self.scale) and self.scale > 0.0):
            raise InputError(f"given {self.scale}; a scale must be finite and positive", key="scale")

    @property
    def bounded(self) -> bool:
        """Whether anything limits or slews a command."""
        return any(map(isfinite, (self.low, self.high, self.rate)))

    @property
    def size(self) -> float:
        """The size that control activity is counted in."""
        half = 0.5 * (self.high - self.low)
        return self.scale if self.scale is not None else half if isfinite(half) else 1.0

    def periods(self, h: float) -> int:
        """Return the delay in control periods h [s]; InputError where it is not a whole number of them, or too many."""
        periods = round(self.delay / h)
        if abs(self.delay - periods * h) > 1e-9 * h * max(periods, 1):
            raise InputError(
                f"given {self.delay:g} s; a delay must be a whole number of control periods of {h:g} s", key="delay"
            )
        if periods > MAX_DELAY:
            raise InputError(
                f"given {self.delay:g} s, {periods} control periods; allowed: up to {MAX_DELAY}, a control period from "
                f"{self.delay / MAX_DELAY:.3g} s",
                key="delay",
            )
        return periods


@dataclass(frozen=True)
class Channel:
    """One loop: a law between an output and an input, or the set point of another channel.

    output: the output that it controls; rate_output: the output that measures its rate, None where the law takes it from its own
    observer, or from the difference of the output over the channel's step. to: input or channel that its command goes to. b0:
    acceleration of the output for one unit of command, in the controller's model; 1 for gains in units of the command. every:
    control periods between its steps. limit: largest |error| of a flight that has not failed [unit of the output]. low, high:
    limits of its command.
    """

    name: str
    law: Law
    output: str
    to: str
    b0: float = 1.0
    rate_output: str | None = None
    every: int = 1
    limit: float = inf
    low: float = -inf
    high: float = inf

    def __post_init__(self) -> None:
        if not (isfinite(self.b0) and self.b0 != 0.0):
            raise InputError(f"given {self.b0}; allowed: a finite number that is not 0", key="b0")
        if self.every < 1:
            raise InputError(f"given {self.every}; allowed: 1 or more control periods", key="every")
        if not self.limit > 0.0:
            raise InputError(f"given {self.limit}; a limit must be positive", key="limit")
        if not self.low < self.high:
            raise InputError(f"given [{self.low}, {self.high}]; the lower end must be below the upper end", key="low")


class WatchedSignal(NamedTuple):
    """A signal that no channel controls: its meters count its own value, as an error from 0.

    Attributes:
        name: Name of an output, or of an input, whose value is the command in force.
        record: "Output" or "Input".
        limit: Largest |value| of a flight that has not failed [unit of the signal].
    """

    name: str
    record: str
    limit: float = inf

    @property
    def expression(self) -> str:
        """Expression of its sample at a control instant."""
        return f"AxisSample(0.0, {'body.shown' if self.record == 'Output' else 'control.command'}.{self.name})"


@dataclass(frozen=True)
class LoopPlan:
    """The loops of a plant: channels, outer ones before the inner ones that they command, and an actuator for every input.

    watched: other signals that meters judge. They decide code and limits of a loop, so its identity counts them there.
    observer: estimates the outputs that no sensor measures; its numbers belong to the nominal model of the controller.
    """

    channels: tuple[Channel, ...]
    actuators: tuple[Actuator, ...]
    watched: tuple[WatchedSignal, ...] = field(default=(), compare=False)
    observer: Observer | None = field(default=None, compare=False)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the channels."""
        return tuple(channel.name for channel in self.channels)

    @property
    def judged(self) -> tuple[str, ...]:
        """Names of all that meters judge: channels, then watched signals."""
        return (*self.names, *[signal.name for signal in self.watched])

    @property
    def limits(self) -> dict[str, float]:
        """Largest |error| of a flight that has not failed, by name."""
        return {each.name: each.limit for each in (*self.channels, *self.watched)}

    @property
    def scales(self) -> dict[str, float]:
        """The size that the command of each input is counted in, by the input's name."""
        return {actuator.name: actuator.size for actuator in self.actuators}

    def watching(self, signals: Iterable[WatchedSignal]) -> "LoopPlan":
        """Return the plan with more watched signals; InputError where the loop has another use of a name."""
        added = tuple(signals)
        for signal in added:
            if signal.name in TAKEN:
                raise InputError(
                    f"given '{signal.name}'; the loop calls something else so: give the signal of the plant another name"
                )
        return replace(self, watched=(*self.watched, *added))

    def cascades(self, channel: Channel) -> bool:
        """Return True if a channel commands another one: one named like its input acts on that."""
        return channel.to in self.names and channel.to != channel.name

    @property
    def commanded(self) -> dict[str, str]:
        """The channel whose set point each cascaded channel is, by the name of the inner one."""
        return {channel.to: channel.name for channel in self.channels if self.cascades(channel)}

    @property
    def outer(self) -> tuple[Channel, ...]:
        """Channels whose set point is a reference."""
        return tuple(channel for channel in self.channels if channel.name not in self.commanded)

    def reading(self, output: str) -> str:
        """Return the expression of an output as channels read it."""
        return self.observer.reading(output) if self.observer else f"seen.{output}"

    @property
    def observer_title(self) -> str:
        """Keys and values that describe the observer, "" without one."""
        return self.observer.title if self.observer else ""

    @property
    def sensed(self) -> set[str]:
        """Names of the outputs that the controller measures."""
        read = {name for each in self.channels for name in (each.output, each.rate_output) if name}
        return read if self.observer is None else set(self.observer.measured)

    def number(self, name: str) -> float:
        """Return the place of a channel as the number that model functions carry."""
        return float(self.names.index(name))

    def channel(self, name: str) -> Channel:
        """Return the channel of that name."""
        return self.channels[self.names.index(name)]

    def command_unit(self, plant: PlantRecords, channel: Channel) -> str:
        """Return the unit of a channel's command: that of its input, or of the output of the channel that it commands."""
        inner = self.cascades(channel)
        return plant.unit(f"Output.{self.channel(channel.to).output}" if inner else f"Input.{channel.to}")

    def acting_on(self, actuator: str) -> tuple[Channel, ...]:
        """Return the channels whose commands add up to an input."""
        return tuple(channel for channel in self.channels if channel.to == actuator and not self.cascades(channel))


def plan_loop(
    plant: PlantRecords,
    channels: Sequence[Channel],
    actuators: Sequence[Actuator] = (),
    watched: tuple[WatchedSignal, ...] = (),
    observer: Observer | None = None,
) -> LoopPlan:
    """Return the plan of a plant's loops, outer channels first; InputError where names, units or connections do not fit."""
    if not channels:
        raise InputError("given no channel; a loop needs at least one", key="channel")
    check_identifiers("channel", [channel.name for channel in channels], ".name")
    for i, channel in enumerate(channels):
        if channel.name in TAKEN:
            message = f"given '{channel.name}'; the loop calls something else so: take another name"
            raise InputError(message, key=f"channel[{i}].name")
    inputs, outputs = paths(plant.Input), paths(plant.Output)
    for actuator in actuators:
        check_name("input", actuator.name, inputs)
    check_identifiers("actuator", [actuator.name for actuator in actuators], ".name")
    for channel in channels:
        _check_channel(channel, [each.name for each in channels], inputs, outputs)
    _check_rates(channels)
    given = {actuator.name: actuator for actuator in actuators}
    ordered, every = tuple(_outer_first(channels)), tuple(given.get(name, Actuator(name)) for name in inputs)
    return LoopPlan(ordered, every, watched, observer)


def check_identifiers(kind: str, names: Sequence[str], leaf: str = "") -> None:
    """Raise InputError, with the place in a list as its key, for what is no name of a field, or stands there twice."""
    for i, name in enumerate(names):
        key = f"{kind}[{i}]{leaf}"
        if name in names[:i]:
            raise InputError(f"given '{name}' twice; names must differ", key=key)
        if not name.isidentifier() or name.startswith("_") or iskeyword(name):
            raise InputError(
                f"given '{name}'; allowed: letters, digits and _, a letter first, no word of Python", key=key
            )


def _check_channel(channel: Channel, names: Sequence[str], inputs: Sequence[str], outputs: Sequence[str]) -> None:
    for key, name in (("output", channel.output), ("rate_output", channel.rate_output)):
        if name is not None and name not in outputs:
            raise UnknownNameError("output", name, outputs, key=f"{channel.name}.{key}")
    targets = [*inputs, *[name for name in names if name != channel.name]]
    check_name("input or channel", channel.to, targets, key=f"{channel.name}.to")


def _check_rates(channels: Sequence[Channel]) -> None:
    given = {channel.name: channel for channel in channels}
    for outer in channels:
        inner = given.get(outer.to)
        if inner is not None and outer.every % inner.every:
            raise InputError(
                f"given {outer.every}; '{inner.name}', which it commands, steps every {inner.every} periods: allowed is a "
                "multiple of that",
                key=f"{outer.name}.every",
            )


def _outer_first(channels: Sequence[Channel]) -> Iterator[Channel]:
    """Yield channels so that each stands before the one it commands; InputError for a ring, which no order can decide."""
    left = list(channels)
    names = [channel.name for channel in channels]
    commanded = [channel.to for channel in channels if channel.to in names and channel.to != channel.name]
    twice = next((name for i, name in enumerate(commanded) if name in commanded[:i]), None)
    if twice is not None:
        raise InputError("given two channels that command its set point; allowed: one", key=f"{twice}.to")
    while left:
        ready = [each for each in left if each.name not in [other.to for other in left if other is not each]]
        if not ready:
            ring = " -> ".join(each.name for each in left)
            raise InputError(
                f"an algebraic loop: {ring} command each other in a ring; let one of them go to an input", key="channel"
            )
        yield ready[0]
        left.remove(ready[0])
