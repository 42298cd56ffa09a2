"""The closed loop of a plant of the user's own: its records and functions, put together from the plan of its channels.

At t = k h every channel reads its output, decides and hands its command on; the sum on each input is limited, slewed and delayed;
actuators lag and the plant moves over the period by Runge-Kutta steps. What the outputs show at k is what they were at the end of
the period before, with the input and the disturbance of that period, so no loop is closed without a state in it.

Model functions have no loops over fields, so the functions are written out, line by line, for the channels at hand.
"""

import linecache
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from plant.laws.channel import Applied, Measured, Setpoint
from plant.laws.channel import Channel as Known
from plant.loop import LARGEST_STATE, ClosedLoop, LoopRecords, MeterModel
from plant.model.plan import Channel, LoopPlan
from plant.model.plant_model import PlantModel
from plant.primitives import absolute, both, clip, either, floor, maximum, minimum, select
from plant.records import axpy_of, paths, record_type, selector
from plant.sample import AxisSample
from plant.targets import Target

Function = Callable[..., Any]


class Range(NamedTuple):
    """Limits of a command [its unit], and how far it may move in a control period."""

    low: float
    high: float
    step: float


class Lag(NamedTuple):
    """Pole of an actuator [1/s]; 0 for none, where the plant feels the command itself."""

    pole: float


@dataclass(frozen=True)
class PlantLoop(ClosedLoop):
    """The closed loop of a plant, bound to its channels and to meters."""

    plant: PlantModel
    plan: LoopPlan


def written(name: str, lines: list[str], names: dict[str, Any]) -> Function:
    """Return the function that stands in these lines, with names as its globals; tracebacks show the lines."""
    source = "\n".join(lines) + "\n"
    file = f"<{name} of the loop>"
    linecache.cache[file] = (len(source), None, source.splitlines(True), file)
    world = {"__name__": __name__, **names}
    exec(compile(source, file, "exec"), world)
    return world[name]


def fields(name: str, kinds: dict[str, Any]) -> Any:
    """Return a record type of these fields."""
    return record_type(name, kinds)


def body_type(plant: PlantModel) -> Any:
    """Return the record of the plant's state with its actuators and what its outputs show."""
    return record_type("Body", {"state": plant.State, "actuators": plant.Input, "shown": plant.Output})


def dynamics_type(plant: PlantModel, plan: LoopPlan) -> Any:
    """Return the record of the constants of the plant that flies."""
    lags = record_type("Lags", {actuator.name: Lag for actuator in plan.actuators})
    return record_type("PlantDynamics", {"parameters": plant.Parameters, "lags": lags})


def stepping(plant: PlantModel, plan: LoopPlan) -> Function:
    """Return advance(body, command, disturbance, dynamics, h): one classical Runge-Kutta step of plant and actuators."""
    State, Input = plant.State, plant.Input
    Body = body_type(plant)
    Moving = record_type("Moving", {"state": State, "actuators": Input})
    names = {
        "State": State, "Input": Input, "Body": Body, "Moving": Moving, "derivative": plant.derivative,
        "output": plant.output, "axpy": axpy_of(Moving), "select": select, "lagged": lagged, "felt": felt,
    }  # fmt: skip
    inputs = paths(Input)
    moving = ", ".join(f"lagged(at.actuators.{name}, command.{name}, lags.{name}.pole)" for name in inputs)
    acting = ", ".join(f"felt(at.actuators.{name}, command.{name}, lags.{name}.pole)" for name in inputs)
    names["acting"] = written("acting", ["def acting(at, command, lags):", f"    return Input({acting})"], names)
    rate = [
        "def rate(at, command, disturbance, f):",
        "    return Moving(",
        "        derivative(at.state, acting(at, command, f.lags), disturbance, f.parameters),",
        f"        Input({moving.replace('lags.', 'f.lags.')}),",
        "    )",
    ]
    names["rate"] = written("rate", rate, names)
    step = [
        "def advance(body, command, disturbance, f, h):",
        "    at = Moving(body.state, body.actuators)",
        "    k1 = rate(at, command, disturbance, f)",
        "    k2 = rate(axpy(at, 0.5 * h, k1), command, disturbance, f)",
        "    k3 = rate(axpy(at, 0.5 * h, k2), command, disturbance, f)",
        "    k4 = rate(axpy(at, h, k3), command, disturbance, f)",
        "    end = axpy(axpy(axpy(axpy(at, h / 6.0, k1), h / 3.0, k2), h / 3.0, k3), h / 6.0, k4)",
        "    now = acting(end, command, f.lags)",
        "    return Body(end.state, now, output(end.state, now, disturbance, f.parameters))",
    ]
    return written("advance", step, names)


def lagged(position: float, command: float, pole: float) -> float:
    """Rate of a first-order actuator [unit/s]: (command - position)/lag."""
    return pole * (command - position)


def felt(position: float, command: float, pole: float) -> float:
    """Return the input that the plant feels: where the actuator is, or the command where it has no lag."""
    return select(pole > 0.0, position, command)


def limited(asked: float, previous: float, within: Range) -> float:
    """Return a command within its limits and no further from the one before than it may move in a period."""
    return clip(clip(asked, previous - within.step, previous + within.step), within.low, within.high)


def to_plant(command: float, channel: float) -> float:  # noqa: ARG001
    """Return the command of an input as it goes to the plant; margins break the loop of a channel here."""
    return command


def to_channel(command: float, channel: float) -> float:  # noqa: ARG001
    """Return the command of a channel as the set point of the one that it commands; margins break its loop here."""
    return command


def due(time: float, h: float, every: float) -> bool:
    """Return whether a channel that steps every so many periods steps at this time; the first instant counts."""
    k = floor(time / h + 0.5)
    return k - every * floor((k + 0.5) / every) < 0.5


def _channel_lines(channel: Channel, plan: LoopPlan) -> list[str]:
    """Lines that step one channel: its set point, its command and its memory."""
    name = channel.name
    outer = plan.commanded.get(name)
    goal = f"Setpoint(to_channel(u_{outer}, {plan.number(outer)}), 0.0, 0.0)" if outer else f"reference.{name}"
    rate = f"seen.{channel.rate_output}" if channel.rate_output else "0.0"
    inner = channel.to in plan.names
    effect = f"kept.commands.{name}" if inner else f"flight.in_force.{channel.to}"
    excess = f"kept.excess.{name}" if inner else f"flight.excess.{channel.to} + kept.excess.{name}"
    lines = [
        f"    goal_{name} = {goal}",
        f"    asked_{name}, memory_{name} = step_{name}(kept.{name}, constants.{name}, nominal.{name}, goal_{name},",
        f"        Measured(seen.{channel.output}, {rate}), Applied({effect}, {excess}), {float(channel.every)} * h)",
        f"    u_{name} = clip(asked_{name}, nominal.commands.{name}.low, nominal.commands.{name}.high)",
        f"    over_{name} = u_{name} - asked_{name}",
    ]
    if channel.every > 1:
        lines += [
            f"    due_{name} = due(time, h, {float(channel.every)})",
            f"    u_{name} = select(due_{name}, u_{name}, kept.commands.{name})",
            f"    over_{name} = select(due_{name}, over_{name}, kept.excess.{name})",
            f"    memory_{name} = keep_{name}(due_{name}, memory_{name}, kept.{name})",
        ]
    return lines


def _queue_lines(name: str, periods: int) -> tuple[str, str]:
    """Expressions of the input that comes into force, and of the queue behind it."""
    if not periods:
        return f"u_{name}", ""
    waiting = [f"flight.waiting.{name}.p{i}" for i in range(periods)]
    return waiting[0], f"Queue_{name}({', '.join([*waiting[1:], f'u_{name}'])})"


def close_plant(plant: PlantModel, plan: LoopPlan, meter: MeterModel, h: float) -> PlantLoop:
    """Bind the closed loop of a plant to the plan of its channels and to the meters that judge it, at control period h [s]."""
    return _Closing(plant, plan, meter, h).loop()


class _Closing:
    """Record types of one loop, and its functions."""

    def __init__(self, plant: PlantModel, plan: LoopPlan, meter: MeterModel, h: float) -> None:
        self.plant, self.plan, self.meter = plant, plan, meter
        channels = plan.channels
        self.delays = {each.name: each.periods(h) for each in plan.actuators}
        self.Body = body_type(plant)
        self.Gains = fields("Gains", {each.name: each.law.Gains for each in channels})
        self.Constants = fields("Constants", {each.name: each.law.Constants for each in channels})
        self.Commands = fields("Commands", dict.fromkeys(plan.names, float))
        memories = {each.name: each.law.Memory for each in channels}
        self.Control = fields("Control", {**memories, "commands": self.Commands, "excess": self.Commands})
        ranges = fields("CommandRanges", dict.fromkeys(plan.names, Range))
        inputs = fields("InputRanges", {each.name: Range for each in plan.actuators})
        self.Nominal = fields("Nominal", {**dict.fromkeys(plan.names, Known), "commands": ranges, "inputs": inputs})
        self.Reference = fields("References", dict.fromkeys(plan.names, Setpoint))
        self.Targets = fields("Targets", dict.fromkeys(plan.names, Target))
        self.Limits = fields("Limits", dict.fromkeys(plan.names, float))
        self.queues = {
            name: fields(f"Queue_{name}", {f"p{i}": float for i in range(count)})
            for name, count in self.delays.items()
            if count
        }
        self.Waiting = fields("Waiting", self.queues)
        self.Sample = fields(
            "PlantSample",
            {
                "time": float, **dict.fromkeys(plan.names, AxisSample), "command": plant.Input, "previous": plant.Input,
                "saturated": float,
            },
        )  # fmt: skip
        self.Flight = fields(
            "PlantFlight",
            {
                "body": self.Body, "speed": plant.Input, "in_force": plant.Input, "asked": plant.Input, "excess": plant.Input,
                **({"waiting": self.Waiting} if self.queues else {}),
                "control": self.Control, "meters": meter.Meters, "status": float, "end_time": float,
            },
        )  # fmt: skip

    @property
    def names(self) -> dict[str, Any]:
        """Globals of the functions that are written out."""
        laws = {each.name: each.law for each in self.plan.channels}
        return {
            **{f"step_{name}": law.step for name, law in laws.items()},
            **{f"prepare_{name}": law.prepare for name, law in laws.items()},
            **{f"start_{name}": law.start for name, law in laws.items()},
            **{f"keep_{each.name}": selector(each.law.Memory) for each in self.plan.channels if each.every > 1},
            **{f"Queue_{name}": kind for name, kind in self.queues.items()},
            "Constants": self.Constants, "Control": self.Control, "Commands": self.Commands, "Flight": self.Flight,
            "Input": self.plant.Input, "Output": self.plant.Output, "Waiting": self.Waiting, "Sample": self.Sample,
            "AxisSample": AxisSample, "Setpoint": Setpoint, "Measured": Measured, "Applied": Applied, "clip": clip,
            "select": select, "both": both, "either": either, "absolute": absolute, "maximum": maximum, "minimum": minimum,
            "due": due, "limited": limited, "to_plant": to_plant, "to_channel": to_channel,
            "keep_meters": selector(self.meter.Meters), "meter_start": self.meter.start,
            "meter_update": self.meter.update, "LARGEST": LARGEST_STATE,
        }  # fmt: skip

    def loop(self) -> PlantLoop:
        """Return the closed loop."""
        records = LoopRecords(
            self.Gains, self.Nominal, self.Reference, self.plant.Disturbance, fields("PlantNoise", {"output": self.plant.Output}),
            dynamics_type(self.plant, self.plan), self.Targets, self.Limits, len(paths(self.plant.Disturbance)),
        )  # fmt: skip
        names = self.names
        names["sense"] = self._sense(names)
        names["status_of"] = self._status(names)
        return PlantLoop(
            self.plant.name, records, self.Constants, self.Flight, self._prepare(names), place, self._start(names),
            self._decide(names), stepping(self.plant, self.plan), self.plant, self.plan,
        )  # fmt: skip

    def _prepare(self, names: dict[str, Any]) -> Function:
        each = ", ".join(f"prepare_{c.name}(gains.{c.name}, {float(c.every)} * h)" for c in self.plan.channels)
        return written("prepare", ["def prepare(gains, h):", f"    return Constants({each})"], names)

    def _sense(self, names: dict[str, Any]) -> Function:
        each = ", ".join(f"shown.{path} + noise.output.{path}" for path in paths(self.plant.Output))
        return written("sense", ["def sense(shown, noise):", f"    return Output({each})"], names)

    def _status(self, names: dict[str, Any]) -> Function:
        """Write status_of(state, sample, limits): 0 while the flight may go on, 2 beyond a limit, 3 where it is no number."""
        size = " + ".join(f"state.{path} * state.{path}" for path in paths(self.plant.State))
        lines = ["def status_of(state, sample, limits):", f"    size = {size}", "    inside = size < LARGEST"]
        for name in self.plan.names:
            error = f"absolute(sample.{name}.reference - sample.{name}.actual)"
            lines.append(f"    inside = both(inside, {error} < limits.{name})")
        return written("status_of", [*lines, "    return select(size < LARGEST, select(inside, 0.0, 2.0), 3.0)"], names)

    def _sample(self, command: str, previous: str, saturated: str) -> str:
        axes = ", ".join(f"AxisSample(goal_{c.name}.value, body.shown.{c.output})" for c in self.plan.channels)
        return f"Sample(time, {axes}, {command}, {previous}, {saturated})"

    def _start(self, names: dict[str, Any]) -> Function:
        lines = ["def start(body, constants, nominal, reference, noise, targets):", "    time = 0.0"]
        lines += ["    seen, held = sense(body.shown, noise), body.actuators"]
        for c in self.plan.channels:
            rate = f"seen.{c.rate_output}" if c.rate_output else "0.0"
            share = len(self.plan.acting_on(c.to)) or 1
            lines += [
                f"    u_{c.name} = "
                + (
                    f"body.shown.{self._output_of(c.to)}"
                    if c.to in self.plan.names
                    else f"held.{c.to} / {float(share)}"
                ),
                f"    memory_{c.name} = start_{c.name}(constants.{c.name}, Measured(seen.{c.output}, {rate}), "
                f"nominal.{c.name}.b0 * u_{c.name})",
                f"    goal_{c.name} = "
                + (
                    f"Setpoint(body.shown.{c.output}, 0.0, 0.0)"
                    if c.name in self.plan.commanded
                    else f"reference.{c.name}"
                ),
            ]
        commands = ", ".join(f"u_{name}" for name in self.plan.names)
        memories = ", ".join(f"memory_{name}" for name in self.plan.names)
        nothing = ", ".join("0.0" for _ in self.plan.names)
        still = ", ".join("0.0" for _ in paths(self.plant.Input))
        waiting = [f"Queue_{name}({', '.join([f'held.{name}'] * self.delays[name])})" for name in self.queues]
        lines += [
            f"    sample = {self._sample('held', 'held', '0.0')}",
            f"    control = Control({memories}, Commands({commands}), Commands({nothing}))",
            f"    return Flight(body, held, held, held, Input({still}), "
            + (f"Waiting({', '.join(waiting)}), " if waiting else "")
            + "control, meter_start(sample, targets), 0.0, 0.0)",
        ]
        return written("start", lines, names)

    def _output_of(self, channel: str) -> str:
        return next(each.output for each in self.plan.channels if each.name == channel)

    def _decide(self, names: dict[str, Any]) -> Function:
        lines = [
            "def decide(flight, constants, nominal, reference, noise, targets, limits, time, h):",
            "    body, kept = flight.body, flight.control",
            "    seen = sense(body.shown, noise)",
        ]
        for channel in self.plan.channels:
            lines += _channel_lines(channel, self.plan)
        forces, speeds, queues, at_limit = [], [], [], []
        for actuator in self.plan.actuators:
            name = actuator.name
            asked = " + ".join(f"u_{each.name}" for each in self.plan.acting_on(name)) or f"flight.asked.{name}"
            lines += [
                f"    wanted_{name} = {asked}",
                f"    u_{name} = limited(wanted_{name}, flight.asked.{name}, nominal.inputs.{name})",
                f"    short_{name} = u_{name} - wanted_{name}",
            ]
            force, queue = _queue_lines(name, self.delays[name])
            forces.append(force)
            first = self.plan.acting_on(name)[:1]
            speeds.append(f"to_plant({force}, {self.plan.number(first[0].name)})" if first else force)
            queues += [queue] if queue else []
            at_limit.append(f"absolute(short_{name}) > 0.0")
        saturated = at_limit[0]
        for condition in at_limit[1:]:
            saturated = f"either({saturated}, {condition})"
        inputs = paths(self.plant.Input)
        asked = f"Input({', '.join(f'u_{name}' for name in inputs)})"
        short = f"Input({', '.join(f'short_{name}' for name in inputs)})"
        each = {key: ", ".join(f"{key}_{name}" for name in self.plan.names) for key in ("memory", "u", "over")}
        lines += [
            f"    in_force, asked = Input({', '.join(forces)}), {asked}",
            f"    speed = Input({', '.join(speeds)})",
            f"    sample = {self._sample('asked', 'flight.asked', f'select({saturated}, 1.0, 0.0)')}",
            "    status = select(flight.status < 0.5, status_of(body.state, sample, limits), flight.status)",
            "    alive = status < 0.5",
            "    meters = keep_meters(alive, meter_update(flight.meters, sample, targets, h), flight.meters)",
            "    end_time = select(alive, time + h, flight.end_time)",
            f"    control = Control({each['memory']}, Commands({each['u']}), Commands({each['over']}))",
            f"    return Flight(body, speed, in_force, asked, {short}, "
            + (f"Waiting({', '.join(queues)}), " if queues else "")
            + "control, meters, status, end_time)",
        ]
        return written("decide", lines, names)


def place(body: Any, reference: Any) -> Any:  # noqa: ARG001
    """Return the body as it was drawn: a plant starts where it rests, not where its reference starts."""
    return body
