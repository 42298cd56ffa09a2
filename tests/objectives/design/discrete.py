"""Designed loops as they are sampled, built from the laws' own steps and an exact axis: nothing of the design is used here.

The command of the law is replaced where it enters the rotors (or the attitude loop); what the law knows of its command is its
own. Everything is linear, so the matrices are found by unit steps.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import control
import numpy as np
from numpy.typing import NDArray

from plant.law_registry import LAWS
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.records import flatten, pack, size

Array = NDArray[np.float64]
Step = Callable[[Array, float], tuple[Array, float]]


@dataclass(frozen=True)
class Rotors:
    """First-order lag [s] behind a hold of h [s], with one period of computing where late; aware: the law knows the lag; lead [s]:
    of the acceleration, which is what is delivered plus lead times its rate.
    """

    lag: float
    h: float
    late: bool = True
    aware: bool = True
    lead: float = 0.0

    def advance(self, state: Array, command: float) -> tuple[Array, float, float]:
        """(pending, a) after a period; the command held, and the mean of what is delivered."""
        pending, a = state
        held = pending if self.late else command
        e = math.exp(-self.h / self.lag)
        mean = held + (a - held) * self.lag / self.h * (1.0 - e)
        return np.array([command, held + (a - held) * e]), held, mean


def move(y: float, v: float, a: float, held: float, rotors: Rotors) -> tuple[float, float]:
    """Double integrator under an acceleration that goes from a to held with the rotors' lag, and its lead, over one period."""
    h, tau = rotors.h, rotors.lag
    e = math.exp(-h / tau)
    gone = (a - held) * tau
    rise = gone * (1.0 - e)
    ahead = rotors.lead * rise - rotors.lead * a * h + rotors.lead * held * h
    faster = rotors.lead * (held - a) * (1.0 - e)
    return y + h * v + 0.5 * h * h * held + gone * (h - tau * (1.0 - e)) + ahead, v + h * held + rise + faster


@dataclass(frozen=True)
class Loop:
    """One law with linear gains on one channel of b0 = 1; observed: the rate comes from its observer."""

    law: str
    gains: Any
    observed: bool = False

    @property
    def memory(self) -> int:
        return size(LAWS[self.law].Memory)

    def step(self, memory: Array, reference: float, y: float, v: float, effect: float, h: float) -> tuple[Array, float]:
        law = LAWS[self.law]
        command, after = law.step(
            pack(law.Memory, memory.tolist()),
            law.prepare(self.gains, h),
            Channel(1.0, float(self.observed)),
            Setpoint(reference, 0.0, 0.0),
            Measured(y, v),
            Applied(effect, 0.0),
            h,
        )
        return np.array(flatten(after)), command


def attitude_step(loop: Loop, rotors: Rotors) -> tuple[int, Step]:
    """State: memory, the law's own (pending, a, effect), the axis' (pending, a, y, v)."""
    m = loop.memory

    def step(x: Array, injected: float) -> tuple[Array, float]:
        own, effect, axis, (y, v) = x[m : m + 2], x[m + 2], x[m + 3 : m + 5], x[m + 5 :]
        memory, command = loop.step(x[:m], 0.0, y, v, effect, rotors.h)
        own, held, mean = rotors.advance(own, command)
        moved, pushed, _ = rotors.advance(axis, injected)
        known = mean if rotors.aware else held
        return np.concatenate([memory, own, [known], moved, move(y, v, axis[1], pushed, rotors)]), command

    return m + 7, step


def tracking(loop: Loop, rotors: Rotors) -> tuple[int, Callable[[Array, float], Array]]:
    """The closed attitude loop under a reference; state: memory, (pending, a, effect), angle, rate."""
    m = loop.memory

    def step(x: Array, reference: float) -> Array:
        own, effect, (y, v) = x[m : m + 2], x[m + 2], x[m + 3 :]
        memory, command = loop.step(x[:m], reference, y, v, effect, rotors.h)
        after, held, mean = rotors.advance(own, command)
        return np.concatenate([memory, after, [mean if rotors.aware else held], move(y, v, own[1], held, rotors)])

    return m + 5, step


def position_step(outer: Loop, inner: Loop, rotors: Rotors) -> tuple[int, Step]:
    """State: outer memory, the attitude that the law's own demand leads to, that of the injected one, place, speed, last demand."""
    m, (n, follow) = outer.memory, tracking(inner, rotors)
    parts = 20

    def step(x: Array, injected: float) -> tuple[Array, float]:
        own, axis, (y, v, asked) = x[m : m + n], x[m + n : m + 2 * n], x[m + 2 * n :]
        effect = own[-2] if rotors.aware else asked
        memory, command = outer.step(x[:m], 0.0, y, v, effect, rotors.h)
        after = follow(axis, injected)
        # The angle moves smoothly over a period: Simpson's rule on the cubic through its ends.
        h, (a0, d0), (a1, d1) = rotors.h, axis[-2:], after[-2:]
        s = np.linspace(0.0, 1.0, parts + 1)
        angle = (
            a0 * (1 + 2 * s) * (1 - s) ** 2
            + h * d0 * s * (1 - s) ** 2
            + a1 * s**2 * (3 - 2 * s)
            + h * d1 * s**2 * (s - 1)
        )
        moved = y + h * v + h * h * np.trapezoid((1.0 - s) * angle, s), v + h * np.trapezoid(angle, s)
        return np.concatenate([memory, follow(own, command), after, moved, [command]]), command

    return m + 2 * n + 3, step


def open_loop(system: tuple[int, Step], h: float) -> Any:
    """Return L of python-control, from the injected command to minus the law's."""
    n, step = system
    after, out = zip(*[step(unit, 0.0) for unit in np.eye(n)], strict=True)
    pushed, direct = step(np.zeros(n), 1.0)
    return control.ss(np.array(after).T, pushed[:, None], -np.array(out)[None], -np.array([[direct]]), h)


@dataclass(frozen=True)
class Margins:
    """Peaks of S and T, phase margin [deg], least factor by which the gain may rise and fall; all 0 or inf where unstable."""

    ms: float
    mt: float
    phase: float
    rise: float
    fall: float


def margins(system: tuple[int, Step], h: float) -> Margins:
    """Margins by python-control, on the sampled loop."""
    loop = open_loop(system, h)
    closed: Any = control.feedback(loop, 1)
    if np.abs(closed.poles()).max(axis=0) >= 1.0:
        return Margins(np.inf, np.inf, 0.0, 1.0, 1.0)
    omega = np.geomspace(1e-2, 0.999 * np.pi / h, 1200)
    curve = control.frd(loop, omega, smooth=True)
    gains, phases, distances, *_ = control.stability_margins(curve, returnall=True)
    rising, falling = [g for g in gains if g > 1.0], [1.0 / g for g in gains if 0.0 < g < 1.0]
    response = curve.complex
    mt = float(np.abs(response / (1.0 + response)).max(axis=0))
    return Margins(
        1.0 / min(distances),
        mt,
        float(np.abs(phases).min(axis=0)),
        min(rising, default=np.inf),
        min(falling, default=np.inf),
    )
