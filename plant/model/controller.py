"""The controller of a plant of the user's own: from measured outputs and references to commands, and all that it keeps between.

Every period each channel reads its output, decides and hands its command on; the sum on each input is limited and slewed, and
comes into force after as many periods as the delay in the controller's model. The closed loop flies these functions
(`plant.model.closing`), and exported C is traced from them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from typing import Annotated, Any, NamedTuple

from plant.laws.channel import Applied, Measured, Setpoint
from plant.laws.channel import Channel as NominalChannel
from plant.model.functions import written
from plant.model.plan import Actuator, Channel, LoopPlan
from plant.model.plant_model import PlantRecords
from plant.primitives import maximum, minimum, select
from plant.records import paths, record_type, selector

Function = Callable[..., Any]
# Parts of the memory, and what the functions call their records.
PARTS = {
    "laws": "Laws",
    "commands": "Commands",
    "excess": "Commands",
    "command": "Input",
    "shortfall": "Input",
    "in_force": "Input",
    "waiting": "Waiting",
    "phase": "Phase",
    "last": "Last",
    "estimate": "Estimate",
}


class Range(NamedTuple):
    """Limits of a command [its unit], and how far it may move in a control period."""

    low: float
    high: float
    step: float


@dataclass(frozen=True)
class PlantController:
    """The controller of a plan's channels at one control period.

    Gains, Constants: of the law of every channel. Nominal: its knowledge: every channel in its law's model, then the ranges of
    `commands` of channels and of `inputs`. Reference: a set point for every channel; those of inner ones are not read.
    Memory: laws; commands and excess of channels; command of inputs: what they were last sent; shortfall: that less what was
    wanted; in_force: what has come into force; waiting: what is on its way; phase: periods since a slower channel stepped;
    last: what a channel without a measured rate saw when it last stepped, because its rate is the difference over its step;
    estimate: outputs by the observer.
    prepare(gains, h) -> Constants. start(constants, nominal, seen, held) -> Memory at rest at the outputs seen, with the inputs
    held. step(memory, constants, nominal, reference, seen, h) -> Memory, once every period; its `command` is to be sent.
    """

    Gains: Any
    Constants: Any
    Nominal: Any
    Reference: Any
    Memory: Any
    prepare: Function
    start: Function
    step: Function


def to_channel(command: float, channel: float) -> float:  # noqa: ARG001
    """Return the command of a channel as the set point of the one that it commands; margins break its loop here."""
    return command


def plant_controller(plant: PlantRecords, plan: LoopPlan, h: float) -> PlantController:
    """Return the controller of a plant's channels at control period h [s]."""
    Gains = record_type("Gains", {each.name: each.law.Gains for each in plan.channels})
    Constants = record_type("Constants", {each.name: each.law.Constants for each in plan.channels})
    Reference = record_type("References", dict.fromkeys(plan.names, Setpoint))
    names = _memory(plant, plan, h) | _laws(plan) | {"Constants": Constants}
    prepared = ", ".join(f"prepare_{each.name}(gains.{each.name}, {float(each.every)} * h)" for each in plan.channels)
    return PlantController(
        Gains,
        Constants,
        _nominal(plan),
        Reference,
        names["Memory"],
        written("prepare", ["def prepare(gains, h):", f"    return Constants({prepared})"], names),
        written("control_start", _start_lines(plan, names["Memory"]), names),
        written("control_step", _step_lines(plan, names["Memory"]), names),
    )


def _nominal(plan: LoopPlan) -> Any:
    commands = record_type("CommandRanges", dict.fromkeys(plan.names, Range))
    inputs = record_type("InputRanges", {each.name: Range for each in plan.actuators})
    parts = {**dict.fromkeys(plan.names, NominalChannel), "commands": commands, "inputs": inputs}
    return record_type("Nominal", parts | ({"observer": plan.observer.numbers_type} if plan.observer else {}))


def _memory(plant: PlantRecords, plan: LoopPlan, h: float) -> dict[str, Any]:
    """Return the record of the memory and those in it, by the names that the functions call them."""
    Laws = record_type("Laws", {each.name: each.law.Memory for each in plan.channels})
    units = {each.name: Annotated[float, plan.command_unit(plant, each)] for each in plan.channels}
    Commands = record_type("Commands", units)
    delays = {each.name: each.periods(h) for each in plan.actuators if each.periods(h)}
    queues = {
        name: record_type(f"Queue_{name}", {f"p{i}": plant.Input.__annotations__[name] for i in range(periods)})
        for name, periods in delays.items()
    }
    Waiting = record_type("Waiting", queues)
    Phase = record_type("Phase", dict.fromkeys([each.name for each in plan.channels if each.every > 1], float))
    seen = {each.name: plant.Output.__annotations__[each.output] for each in plan.channels if not each.rate_output}
    Last = record_type("Last", seen)
    estimated = plan.observer.outputs if plan.observer else ()
    Estimate = record_type("Estimate", {name: plant.Output.__annotations__[name] for name in estimated})
    records = {
        "Laws": Laws,
        "Commands": Commands,
        "Input": plant.Input,
        "Waiting": Waiting,
        "Phase": Phase,
        "Last": Last,
        "Estimate": Estimate,
    }
    Memory = record_type("State", {part: records[name] for part, name in PARTS.items() if records[name]._fields})
    return {"Memory": Memory, **records, **{f"Queue_{name}": kind for name, kind in queues.items()}}


def _laws(plan: LoopPlan) -> dict[str, Any]:
    """Return the other names that the functions call: those of the laws, and primitives."""
    laws = {each.name: each.law for each in plan.channels}
    return {
        **{f"prepare_{name}": law.prepare for name, law in laws.items()},
        **{f"start_{name}": law.start for name, law in laws.items()},
        **{f"step_{name}": law.step for name, law in laws.items()},
        **{f"keep_{each.name}": selector(each.law.Memory) for each in plan.channels if each.every > 1},
        "Setpoint": Setpoint,
        "Measured": Measured,
        "Applied": Applied,
        "to_channel": to_channel,
        "select": select,
        "maximum": maximum,
        "minimum": minimum,
    }


def _seen(plan: LoopPlan, channel: Channel, differenced: str) -> str:
    """Expression of what a channel measures; differenced: its rate where no output measures it."""
    rate = plan.reading(channel.rate_output) if channel.rate_output else differenced
    return f"Measured({plan.reading(channel.output)}, {rate})"


def _start_lines(plan: LoopPlan, memory: Any) -> list[str]:
    lines = [
        "def control_start(constants, nominal, seen, held):",
        *(plan.observer.start_lines if plan.observer else []),
    ]
    for channel in plan.channels:
        name = channel.name
        share = float(len(plan.acting_on(channel.to)))
        inner = plan.cascades(channel)
        held = plan.reading(plan.channel(channel.to).output) if inner else f"held.{channel.to} / {share}"
        lines += [
            f"    u_{name} = {held}",
            f"    last_{name} = {plan.reading(channel.output)}",
            f"    law_{name} = start_{name}(constants.{name}, {_seen(plan, channel, '0.0')}, nominal.{name}.b0 * u_{name})",
        ]
    waiting = [[f"held.{name}"] * periods for name, periods in _queues(memory).items()]
    parts = {"excess": "0.0", "command": "held.{}", "shortfall": "0.0", "in_force": "held.{}", "phase": "0.0"}
    return [*lines, _memory_line(memory, waiting, **parts)]


def _step_lines(plan: LoopPlan, memory: Any) -> list[str]:
    lines = ["def control_step(kept, constants, nominal, reference, seen, h):"]
    lines += plan.observer.step_lines if plan.observer else []
    for channel in plan.channels:
        lines += _channel_lines(channel, plan)
    queues = _queues(memory)
    for actuator in plan.actuators:
        lines += _input_lines(actuator, plan, queues.get(actuator.name, 0))
    waiting = [
        [*[f"kept.waiting.{name}.p{i}" for i in range(1, periods)], f"sent_{name}"] for name, periods in queues.items()
    ]
    parts = {
        "excess": "over_{}",
        "command": "sent_{}",
        "shortfall": "shortfall_{}",
        "in_force": "force_{}",
        "phase": "phase_{}",
    }
    return [*lines, _memory_line(memory, waiting, **parts)]


def _queues(memory: Any) -> dict[str, int]:
    """Return the delays [control periods] of the inputs that are late."""
    waiting = memory.__annotations__.get("waiting", NamedTuple("NoQueue", []))
    return {name: len(paths(kind)) for name, kind in waiting.__annotations__.items()}


def _memory_line(memory: Any, waiting: list[list[str]], **patterns: str) -> str:
    """Return the line that returns the memory; waiting: queues; patterns: of the other parts, where {} is the name of a field."""
    patterns = {"laws": "law_{}", "commands": "u_{}", "last": "last_{}", "estimate": "estimate_{}", **patterns}
    parts: list[str] = []
    for part, kind in memory.__annotations__.items():
        if part == "waiting":
            each = [f"Queue_{name}({', '.join(queue)})" for name, queue in zip(kind._fields, waiting, strict=True)]
        else:
            each = [patterns[part].format(name) for name in kind._fields]
        parts.append(f"{PARTS[part]}({', '.join(each)})")
    return f"    return Memory({', '.join(parts)})"


def _channel_lines(channel: Channel, plan: LoopPlan) -> list[str]:
    """Lines that step one channel: its set point, its command and the memory of its law."""
    name = channel.name
    outer = plan.commanded.get(name)
    goal = f"Setpoint(to_channel(u_{outer}, {plan.number(outer)}), 0.0, 0.0)" if outer else f"reference.{name}"
    inner = plan.cascades(channel)
    effect = f"kept.commands.{name}" if inner else f"kept.in_force.{channel.to}"
    excess = f"kept.excess.{name}" if inner else f"kept.shortfall.{channel.to} + kept.excess.{name}"
    command, over = _limited(f"asked_{name}", f"nominal.commands.{name}", channel.low, channel.high)
    step = f"({float(channel.every)} * h)"
    lines = [
        f"    last_{name} = {plan.reading(channel.output)}",
        f"    asked_{name}, law_{name} = step_{name}(kept.laws.{name}, constants.{name}, nominal.{name}, {goal},",
        f"        {_seen(plan, channel, f'(last_{name} - kept.last.{name}) / {step}')}, Applied({effect}, {excess}), {step})",
        f"    u_{name} = {command}",
        f"    over_{name} = {over.format(f'u_{name}')}",
    ]
    if channel.every > 1:
        lines += [
            f"    due_{name} = kept.phase.{name} < 0.5",
            f"    phase_{name} = select(kept.phase.{name} < {channel.every - 1.5}, kept.phase.{name} + 1.0, 0.0)",
            f"    u_{name} = select(due_{name}, u_{name}, kept.commands.{name})",
            f"    over_{name} = select(due_{name}, over_{name}, kept.excess.{name})",
            f"    law_{name} = keep_{name}(due_{name}, law_{name}, kept.laws.{name})",
        ]
        lines += [] if channel.rate_output else [f"    last_{name} = select(due_{name}, last_{name}, kept.last.{name})"]
    return lines


def _input_lines(actuator: Actuator, plan: LoopPlan, late: int) -> list[str]:
    """Lines that sum up what channels want of one input, what it is sent, and what comes into force so many periods late."""
    name = actuator.name
    wanted = " + ".join(f"u_{each.name}" for each in plan.acting_on(name)) or f"kept.command.{name}"
    lines = [f"    wanted_{name} = {wanted}"]
    place, before, near = f"nominal.inputs.{name}", f"kept.command.{name}", f"wanted_{name}"
    if isfinite(actuator.rate):
        lines.append(f"    near_{name} = minimum(maximum({near}, {before} - {place}.step), {before} + {place}.step)")
        near = f"near_{name}"
    sent, _ = _limited(near, place, actuator.low, actuator.high)
    shortfall = f"sent_{name} - wanted_{name}" if actuator.bounded else "0.0"
    force = f"kept.waiting.{name}.p0" if late else f"sent_{name}"
    return [*lines, f"    sent_{name} = {sent}", f"    shortfall_{name} = {shortfall}", f"    force_{name} = {force}"]


def _limited(expression: str, place: str, low: float, high: float) -> tuple[str, str]:
    """Expressions of a command within the limits that there are, and of its excess, where {} is that command."""
    within = f"maximum({expression}, {place}.low)" if isfinite(low) else expression
    within = f"minimum({within}, {place}.high)" if isfinite(high) else within
    return within, f"{{}} - {expression}" if within != expression else "0.0"
