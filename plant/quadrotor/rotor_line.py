"""Delay line of the rotors.

Commanded speeds wait for whole control periods, the dead time rounded.
Vehicles that are drawn may have each its own dead time; then the line is as long as the longest, and each takes its place of it.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from plant.model.functions import written
from plant.primitives import select
from plant.records import record_type
from plant.vectors import Rotors


class RotorLine(NamedTuple):
    """Speeds on their way to the rotors.

    Queue: record of those that wait. filled(speed, dead_time) -> Queue; passed(queue, speed, h) -> (speed in force, Queue); dead
    time and control period h in s.
    """

    Queue: Any
    filled: Callable[..., Any]
    passed: Callable[..., Any]


def select_rotors(condition: bool, a: Rotors, b: Rotors) -> Rotors:
    """Return a where the condition holds, else b."""
    return Rotors(
        select(condition, a.r1, b.r1),
        select(condition, a.r2, b.r2),
        select(condition, a.r3, b.r3),
        select(condition, a.r4, b.r4),
    )


def rotor_line(delay_steps: int) -> RotorLine:
    """Return a line of some control periods, the oldest speed first."""
    waiting = [f"p{i}" for i in range(delay_steps)]
    Queue = record_type("Queue", dict.fromkeys(waiting, Rotors))
    oldest, *others = [*[f"queue.{name}" for name in waiting], "speed"]
    filled = ["def filled(speed, dead_time):", f"    return Queue({', '.join(['speed'] * delay_steps)})"]
    passed = ["def passed(queue, speed, h):", f"    return {oldest}, Queue({', '.join(others)})"]
    names = {"Queue": Queue}
    return RotorLine(Queue, written("filled", filled, names), written("passed", passed, names))


def rotor_line_up_to(most_steps: int) -> RotorLine:
    """Return a line for several dead times, the latest speed first.

    most_steps: the longest [control periods].
    """
    waiting = [f"p{i}" for i in range(most_steps)]
    Queue = record_type("VariedQueue", {"dead_time": float, **dict.fromkeys(waiting, Rotors)})
    names = {"Queue": Queue, "select_rotors": select_rotors}
    filled = ["def filled(speed, dead_time):", f"    return Queue(dead_time, {', '.join(['speed'] * most_steps)})"]
    moved = ", ".join(["queue.dead_time", "speed", *[f"queue.{name}" for name in waiting[:-1]]])
    passed = [
        "def passed(queue, speed, h):",
        "    felt = speed",
        *[
            f"    felt = select_rotors(queue.dead_time > {i + 0.5} * h, queue.{name}, felt)"
            for i, name in enumerate(waiting)
        ],
        f"    return felt, Queue({moved})",
    ]
    return RotorLine(Queue, written("filled", filled, names), written("passed", passed, names))
