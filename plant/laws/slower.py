"""A law that steps once in several control periods and holds its command between.

It is the law at `every` times the period: what actuators delivered is handed to it as the mean since it last stepped.
"""

from dataclasses import replace
from typing import Any

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.law import Law
from plant.primitives import select
from plant.records import record_type, selector

MAX_PERIODS = 64


def slower(law: Law, every: int) -> Law:
    """Return a law that steps once in so many control periods; itself for 1."""
    if every == 1:
        return law
    Memory = record_type(
        "SlowerMemory", {"law": law.Memory, "turn": float, "count": float, "effect": float, "command": float}
    )
    keep, law_prepare, law_start, law_step = selector(law.Memory), law.prepare, law.start, law.step
    last = every - 1.0

    def prepare(gains: Any, h: float) -> Any:
        return law_prepare(gains, every * h)

    def start(constants: Any, measured: Measured, held: float) -> Any:
        return Memory(law_start(constants, measured, held), 0.0, 0.0, 0.0, 0.0)

    def step(
        memory: Any,
        constants: Any,
        channel: Channel,
        setpoint: Setpoint,
        measured: Measured,
        applied: Applied,
        h: float,
    ) -> tuple[float, Any]:
        due = memory.turn < 0.5
        count, effect = memory.count + 1.0, memory.effect + applied.effect
        mean = Applied(effect / count, applied.excess)
        fresh, inner = law_step(memory.law, constants, channel, setpoint, measured, mean, every * h)
        command = select(due, fresh, memory.command)
        return command, Memory(
            keep(due, inner, memory.law),
            select(due, last, memory.turn - 1.0),
            select(due, 0.0, count),
            select(due, 0.0, effect),
            command,
        )

    return replace(law, Memory=Memory, prepare=prepare, start=start, step=step, every=every, plain=law)


def always_due(law: Law, every: int) -> Law:
    """Return a law that steps in every period as if it were longer: at rest, the slower law."""
    law_prepare, law_step = law.prepare, law.step

    def prepare(gains: Any, h: float) -> Any:
        return law_prepare(gains, every * h)

    def step(
        memory: Any,
        constants: Any,
        channel: Channel,
        setpoint: Setpoint,
        measured: Measured,
        applied: Applied,
        h: float,
    ) -> tuple[float, Any]:
        return law_step(memory, constants, channel, setpoint, measured, applied, every * h)

    return replace(law, prepare=prepare, step=step)
