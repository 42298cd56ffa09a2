"""Controllers of plants of the user's own as tables of entry points."""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from hashlib import blake2b
from math import isfinite
from typing import Annotated, Any

import numpy as np

from objectives.plant_system import PlantSystem
from plant.backends.c_code import Real
from plant.backends.rebind import Rebinder
from plant.backends.stepping import lane_of
from plant.backends.tracing import Constant, Graph, rebinder
from plant.backends.tracing_routines import Routine
from plant.errors import InputError
from plant.model.controller import PlantController
from plant.model.plan import LoopPlan
from plant.model.scenario import PlantScenario, SensorNoise
from plant.model.signals import Step
from plant.model.units import per_time
from plant.records import flatten, pack, record_type, unit_of, zeros
from tuner.exchange.c99 import precision
from tuner.exchange.c99.golden import FAR_OFF, NEXT_TO, OFTEN
from tuner.exchange.c99.precision import as_signals, matrix, signals
from tuner.exchange.c99.sources import Entry, Instant, Program, gain_texts
from tuner.exchange.c99.tracing import Results, named
from tuner.exchange.texts import c_comment

# Step and noise as shares of a channel's limit; next to what is asked for, the noise is so much smaller.
STEP, NOISE, NEAR = 0.3, 0.002, 1e-2
# Words of C and C++, which no member of a structure can be called.
WORDS = frozenset(
    "alignas alignof and and_eq asm auto bitand bitor bool break case catch char char16_t char32_t class compl const const_cast "
    "constexpr continue decltype default delete do double dynamic_cast else enum explicit export extern false float for friend "
    "goto if inline int long mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected public "
    "register reinterpret_cast restrict return short signed sizeof static static_assert static_cast struct switch template this "
    "thread_local throw true try typedef typeid typename union unsigned using virtual void volatile wchar_t while xor "
    "xor_eq".split()
)
LONGEST_PREFIX = 40
"""Letters of the prefix of all names in a bundle; with more, declarations are longer than a line and were cut."""
# Names in the C that no record may take.
TAKEN = ("real", "status", "loop", "init", "step", "floor")


@dataclass(frozen=True)
class TunedPlant:
    """The controller of a plant with its gains.

    Gains are in the order of the leaves of the loop's Gains. Measured: the outputs that channels read. Reference: a set
    point for each channel that no other one commands.
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
    read = system.plan.sensed
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


def plant_program(tuned: TunedPlant) -> Program:
    """Return the table of a plant's controller."""
    plant, plan, controller = tuned.system.plant, tuned.system.plan, tuned.controller
    laws = {each.law.name: each.law for each in plan.channels}
    routines = {name: Routine(f"{c_name(name)}_law", law.step, law.Memory, watched=True) for name, law in laws.items()}
    constants, knowledge = named("constants", tuned.constants), named("", tuned.system.nominal)
    h = Constant(tuned.period, "h")

    def init(_: Graph, measured: Any, held: Any) -> Results:
        return (("next.", rebinder()(controller.start)(constants, knowledge, measured, held)),)

    def step(graph: Graph, state: Any, reference: Any, measured: Any) -> Results:
        work = _with_calls(graph, plan, routines)(controller.step)
        return (("next.", work(state, constants, knowledge, reference, measured, h)),)

    measured, keeps = {"measured": tuned.Measured}, {"state": controller.Memory, "memory": "laws."}
    command = ("command", plant.Input)
    return Program(
        plant.title,
        tuned.period,
        (
            Entry("init", init, {**measured, "held": plant.Input}, **keeps),
            Entry(
                "step",
                step,
                {"reference": tuned.Reference, **measured},
                command,
                **keeps,
                flight=partial(plant_flight, tuned),
            ),
        ),
        routines=tuple(routines.values()),
        gains=gain_texts(tuned.system.gains, tuned.gains),
        declared={name: name for name in TAKEN},
        types={
            "reference_type": tuned.Reference,
            "measured_type": tuned.Measured,
            "input_type": plant.Input,
            "state_type": controller.Memory,
        },
        words={
            "plant": c_comment(plant.name),
            "channels": "\n".join(f"   {line}" for line in channel_lines(plan)),
            "delays": c_comment(delays(tuned)),
        },
        templates="plant_",
        table="_gains",
        note=lambda leaf: f" /* [{c_comment(unit_of(leaf))}] */" if unit_of(leaf) else "",
    )


def channel_lines(plan: LoopPlan) -> list[str]:
    """Return a line for each channel: law, output, where its command goes, how often it steps; and one for an observer."""
    observer = [f"{'observer':<13} {plan.observer_title}"] if plan.observer else []
    return observer + [
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


def _with_calls(graph: Graph, plan: LoopPlan, routines: dict[str, Routine]) -> Rebinder:
    """Return a rebinder to a graph; the channels' laws are calls, in the order in which channels step."""
    order = iter(plan.channels)

    def step(*arguments: Any) -> Any:
        channel = next(order)
        return routines[channel.law.name].call(channel.name, graph, *arguments)

    stand_ins: dict[Callable[..., Any], Callable[..., Any]] = {each.law.step: step for each in plan.channels}
    return rebinder(stand_ins)


def c_name(text: str) -> str:
    """Return a text as a C identifier in lower case; a long one is cut and ends in digits of its hash."""
    plain = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_").lower()
    if len(plain) > LONGEST_PREFIX:
        plain = f"{plain[: LONGEST_PREFIX - 5].rstrip('_')}_{blake2b(plain.encode(), digest_size=2).hexdigest()}"
    return plain if plain[:1].isalpha() else f"plant_{plain}".rstrip("_")


def plant_flight(tuned: TunedPlant, real: Real, steps: int) -> Iterator[Instant]:
    """Yield the instants of a float64 plant under its controller."""
    system, controller, knowledge = tuned.system, tuned.controller, tuned.system.nominal
    bind, constants = precision.rebinder(real), tuned.constants
    start, step = bind(controller.start), bind(controller.step)
    flown = lane_of(system.sample(_scenario(tuned, steps), 0, "export/golden", [0]), 0)
    loop, state = system.loop, None
    body, dynamics = pack(loop.Body, flown.starts.tolist()), pack(loop.records.Dynamics, flown.dynamics.tolist())
    for k, row in enumerate(flown.references):
        goals = pack(loop.records.Reference, row.tolist())
        measured = signals(tuned.Measured, _seen(tuned, body, goals, flown.noises[k], k), real)
        setpoints = [leaf for each in system.plan.outer for leaf in getattr(goals, each.name)]
        reference = signals(tuned.Reference, [[leaf] for leaf in setpoints], real)
        if state is None:
            held = as_signals(body.actuators, real, 1)
            state = as_signals(start(constants, knowledge, measured, held), real, 1)
            yield (measured, held), (), (state,)
        state = as_signals(step(state, constants, knowledge, reference, measured, tuned.period), real, 1)
        yield (reference, measured), (state.command,), (state,)
        body = _advanced(tuned, body, dynamics, matrix(state.in_force)[:, 0].tolist())


def _scenario(tuned: TunedPlant, steps: int) -> PlantScenario:
    """Return a scenario: a step of every outer channel after a tenth of the flight, and noise on all measurements."""
    plan, duration = tuned.system.plan, steps * tuned.period
    sizes = {each.name: each.limit if isfinite(each.limit) else 1.0 for each in plan.channels}
    noises = {name: sizes[each.name] for each in plan.channels for name in (each.rate_output, each.output) if name}
    return PlantScenario(
        "golden",
        duration,
        references={each.name: Step(STEP * sizes[each.name], 0.1 * duration) for each in plan.outer},
        sensors={name: SensorNoise(NOISE * width) for name, width in noises.items()},
    )


def _seen(tuned: TunedPlant, body: Any, goals: Any, noise: np.ndarray, k: int) -> list[list[float]]:
    """Return the measurements at a step; a row for each output that channels read."""
    outputs = tuned.system.plant.Output._fields
    errors = dict(zip(outputs, noise.tolist(), strict=True))
    shown = dict(zip(outputs, flatten(body.shown), strict=True))
    if k % OFTEN == OFTEN - 1:
        errors = {name: FAR_OFF * error for name, error in errors.items()}
    if k % OFTEN == NEXT_TO:
        for each in tuned.system.plan.outer:
            shown[each.output] = getattr(goals, each.name).value
            errors[each.output] *= NEAR
    return [[shown[name] + errors[name]] for name in tuned.Measured._fields]


def _advanced(tuned: TunedPlant, body: Any, dynamics: Any, command: list[float]) -> Any:
    """Return the body one period later."""
    system = tuned.system
    quiet = zeros(system.plant.Disturbance)
    for _ in range(system.timing.steps):
        body = system.loop.advance(body, pack(system.plant.Input, command), quiet, dynamics, system.timing.plant_step)
    return body
