"""The controller of a plant of the user's own as one C99 header and one source, traced from the functions that its loop flies."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from hashlib import blake2b
from math import isfinite
from typing import Annotated, Any

from objectives.plant_system import PlantSystem
from plant.backends.c_code import REALS, literal
from plant.backends.c_records import CRecords
from plant.backends.rebind import Rebinder
from plant.backends.tracing import Constant, Graph, Node, rebinder
from plant.backends.tracing_routines import Routine
from plant.errors import InputError
from plant.model.controller import PlantController
from plant.model.plan import LoopPlan
from plant.model.units import per_time
from plant.records import pack, paths, record_type, unit_of
from tuner.exchange.c99.routines import Style, loops
from tuner.exchange.c99.sources import Code, entry_function, gain_texts, source_text
from tuner.exchange.c99.tracing import TracedFunction, named, traced
from tuner.exchange.texts import c_comment, c_string, filled, tool

# Words of C and C++, which no member of a structure can be called.
WORDS = frozenset(
    "alignas alignof and and_eq asm auto bitand bitor bool break case catch char char16_t char32_t class compl const const_cast "
    "constexpr continue decltype default delete do double dynamic_cast else enum explicit export extern false float for friend "
    "goto if inline int long mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected public "
    "register reinterpret_cast restrict return short signed sizeof static static_assert static_cast struct switch template this "
    "thread_local throw true try typedef typeid typename union unsigned using virtual void volatile wchar_t while xor "
    "xor_eq".split()
)
# Names in the C that no record may take.
LONGEST_PREFIX = 40
"""Letters of the prefix of all names in a bundle; with more, declarations are longer than a line and were cut."""
TAKEN = ("real", "status", "loop", "init", "step", "floor")


@dataclass(frozen=True)
class TunedPlant:
    """The controller of a plant with its gains, in the order of the leaves of the loop's Gains.

    Measured: the outputs that channels read. Reference: a set point for each channel that no other one commands.
    """

    system: PlantSystem
    gains: tuple[float, ...]
    Measured: Any
    Reference: Any

    @property
    def controller(self) -> PlantController:
        """Its records and functions."""
        return self.system.loop.controller

    @property
    def period(self) -> float:
        """Control period [s]."""
        return self.system.timing.control_period

    @property
    def constants(self) -> Any:
        """Constants of all laws, worked out in float64 by their own `prepare`."""
        return self.controller.prepare(pack(self.controller.Gains, self.gains), self.period)


@dataclass(frozen=True)
class PlantCode(Code):
    """C99 of a plant's controller; types: C names of the records by what they are: reference_type, state_type."""

    types: dict[str, str]


def tuned_plant(system: PlantSystem, gains: Sequence[float]) -> TunedPlant:
    """Return a plant's controller with a row of gains; InputError where they do not fit, or a name is none in C."""
    addresses = [gain.address for gain in system.gains]
    if len(gains) != len(addresses):
        raise InputError(
            f"given {len(gains)} gains; this loop has {len(addresses)}: {', '.join(addresses)}", key="gains"
        )
    for address, value in zip(addresses, gains, strict=True):
        if not isfinite(value):
            raise InputError(f"given {value}; a gain must be finite", key=address)
    outputs = system.plant.Output.__annotations__
    read = {name for each in system.plan.channels for name in (each.output, each.rate_output) if name}
    Measured = record_type("Measured", {name: part for name, part in outputs.items() if name in read})
    setpoints = {each.name: _setpoint(each.name, unit_of(outputs[each.output])) for each in system.plan.outer}
    for name in (*system.plan.names, *Measured._fields, *system.plant.Input._fields):
        if name in WORDS or not name.isascii():
            raise InputError(
                f"given '{name}', which is no name in C; allowed: ASCII letters, digits and _, no word of C or C++"
            )
    return TunedPlant(system, tuple(map(float, gains)), Measured, record_type("Reference", setpoints))


def _setpoint(name: str, unit: str) -> Any:
    units = {"value": unit, "rate": per_time(unit), "acceleration": per_time(per_time(unit))}
    return record_type(f"Setpoint_{name}", {field: Annotated[float, unit] for field, unit in units.items()})


def plant_code(tuned: TunedPlant, real: str, prefix: str, digest: str) -> PlantCode:
    """Write the controller; real: "float" or "double"; prefix: of all names, a lower-case identifier; digest: of the gains."""

    def note(leaf: Any) -> str:
        return f" /* [{c_comment(unit_of(leaf))}] */" if unit_of(leaf) else ""

    records = CRecords(prefix, {name: f"{prefix}_{name}" for name in TAKEN}, note)
    style = Style(REALS[real], prefix, records, "_gains")
    kinds = {
        "reference": tuned.Reference,
        "measured": tuned.Measured,
        "input": tuned.system.plant.Input,
        "state": tuned.controller.Memory,
    }
    types = {f"{word}_type": records.name(kind) for word, kind in kinds.items()}
    return PlantCode(_header(tuned, style, digest, types), _source(tuned, style, types), f"{prefix}_controller", types)


def _header(tuned: TunedPlant, style: Style, digest: str, types: dict[str, str]) -> str:
    p, plant = style.prefix, tuned.system.plant
    return filled(
        "c99",
        "plant_controller.h",
        p=p,
        P=p.upper(),
        tool=tool(),
        title=c_comment(plant.title),
        plant=c_comment(plant.name),
        channels="\n".join(f"   {line}" for line in channel_lines(tuned.system.plan)),
        period=f"{tuned.period:.9g}",
        period_literal=literal(tuned.period, style.real),
        real=style.real.name,
        suffix=style.real.suffix,
        digest=c_comment(digest),
        digest_text=c_string(digest),
        delays=c_comment(delays(tuned)),
        typedefs="\n\n".join(style.records.typedefs),
        **types,
    )


def channel_lines(plan: LoopPlan) -> list[str]:
    """Return a line for each channel: law, output, where its command goes, and how often it steps if not every period."""
    return [
        f"{each.name:<13} {each.law.name}, from {each.output} to {each.to}"
        + (f", every {each.every} periods" if each.every > 1 else "")
        for each in plan.channels
    ]


def delays(tuned: TunedPlant) -> str:
    """Return the sentence on the delays that the controller counts on."""
    late = [
        f"{each.name} {each.periods(tuned.period)}"
        for each in tuned.system.plan.actuators
        if each.periods(tuned.period)
    ]
    if not late:
        return "It counts on commands that act in the period in which they are sent."
    return f"It counts on commands that act so many periods after they are sent: {', '.join(late)}. It does not hold them back."


def _source(tuned: TunedPlant, style: Style, types: dict[str, str]) -> str:
    plan = tuned.system.plan
    init, step, routines = _trace(tuned)
    gains = gain_texts(tuned.system.gains, tuned.gains)
    written = {name: loops(routine, style, gains) for name, routine in routines.items()}

    def call(node: Node, local: str, args: list[str]) -> str:
        return written[node.text[1]].call("laws.")(node, local, args)

    def after(node: Node) -> str:
        call, number = node.args
        return f"next.laws.{call.text[2]}.{paths(plan.channel(call.text[2]).law.Memory)[int(number)]}"

    state, measured = f"{types['state_type']} *state", f"const {types['measured_type']} *measured"
    reference, command = f"const {types['reference_type']} *reference", types["input_type"]
    functions = [
        *[each.text for each in written.values()],
        entry_function(style, "init", init, [state, measured, f"const {command} *held"], "state", None),
        entry_function(
            style, "step", step, [state, reference, measured, f"{command} *command"], "state", call, "command", after
        ),
    ]
    return source_text(style, tuned.system.plant.title, functions)


def _trace(tuned: TunedPlant) -> tuple[TracedFunction, TracedFunction, dict[str, Routine]]:
    """Trace init and step; the laws that they call, by the names of their routines."""
    controller, plan = tuned.controller, tuned.system.plan
    laws = {each.law.name: each.law for each in plan.channels}
    routines = {name: Routine(f"{c_name(name)}_law", law.step, law.Memory, watched=True) for name, law in laws.items()}
    constants, knowledge = named("constants", tuned.constants), named("", tuned.system.nominal)
    g = Graph()
    measured, held = g.inputs(tuned.Measured, "measured->"), g.inputs(tuned.system.plant.Input, "held->")
    init = traced(g, ("next.", rebinder()(controller.start)(constants, knowledge, measured, held)))
    g = Graph()
    state, reference = g.inputs(controller.Memory, "state->"), g.inputs(tuned.Reference, "reference->")
    measured, h = g.inputs(tuned.Measured, "measured->"), Constant(tuned.period, "h")
    memory = _with_calls(g, plan, routines)(controller.step)(state, constants, knowledge, reference, measured, h)
    return init, traced(g, ("next.", memory)), {routine.name: routine for routine in routines.values()}


def _with_calls(graph: Graph, plan: LoopPlan, routines: dict[str, Routine]) -> Rebinder:
    """Rebinder to a graph, with the laws of the channels as calls, in the order in which channels step."""
    order = iter(plan.channels)

    def step(*arguments: Any) -> Any:
        channel = next(order)
        return routines[channel.law.name].call(channel.name, graph, *arguments)

    stand_ins: dict[Callable[..., Any], Callable[..., Any]] = {each.law.step: step for each in plan.channels}
    return rebinder(stand_ins)


def c_name(text: str) -> str:
    """Return a text as an identifier of C in lower case, a long one with digits that tell it from others of its beginning."""
    plain = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_").lower()
    if len(plain) > LONGEST_PREFIX:
        plain = f"{plain[: LONGEST_PREFIX - 5].rstrip('_')}_{blake2b(plain.encode(), digest_size=2).hexdigest()}"
    return plain if plain[:1].isalpha() else f"plant_{plain}".rstrip("_")
