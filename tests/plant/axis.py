"""One law on one axis as a linear system, beside what the contract of laws flies it on."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from plant.contract.axis import LOOPS, REST, Axis, H, Input, defaults, random_inputs, run
from plant.laws.channel import Channel, Setpoint
from plant.laws.law import Law
from plant.records import flatten, pack, size
from tests.plant.harness import Array

__all__ = [
    "LOOPS",
    "REST",
    "Axis",
    "H",
    "Input",
    "Linear",
    "Setpoint",
    "continuous_feedback",
    "defaults",
    "linearised",
    "random_inputs",
    "run",
]


@dataclass(frozen=True)
class Linear:
    """m+ = a m + b i, u = c m + d i, with the inputs i in the leaf order of `Input`: exact for a law that is linear."""

    a: Array
    b: Array
    c: Array
    d: Array

    def feedback(self, s: complex, h: float) -> complex:
        """-u/y at the frequency s for the measured y, its rate s y, and delivered what was commanded one period ago."""
        z = np.exp(s * h)
        n = len(self.a)
        inputs = self.d + self.c @ np.linalg.solve(z * np.eye(n) - self.a, self.b)
        _, _, _, value, rate, effect, _ = inputs
        return -(value + s * rate) / (1.0 - effect / z)


def linearised(law: Law, gains: Any, channel: Channel, h: float) -> Linear:
    """Return the matrices of a law that is linear, from unit steps of memory and inputs."""
    n, m = size(law.Memory), size(Input)
    constants = law.prepare(gains, h)

    def respond(memory: Array, inputs: Array) -> tuple[Array, float]:
        setpoint, measured, applied = pack(Input, inputs.tolist())
        u, after = law.step(pack(law.Memory, memory.tolist()), constants, channel, setpoint, measured, applied, h)
        return np.array(flatten(after)), u

    from_memory = [respond(unit, np.zeros(m)) for unit in np.eye(n)]
    from_input = [respond(np.zeros(n), unit) for unit in np.eye(m)]
    return Linear(
        np.array([after for after, _ in from_memory]).T,
        np.array([after for after, _ in from_input]).T,
        np.array([u for _, u in from_memory]),
        np.array([u for _, u in from_input]),
    )


def continuous_feedback(law: Law, gains: Any, from_observer: bool, s: complex) -> complex:
    """The law's -u/y at s for vanishing control period and b0 = 1: values at h and h/2 extrapolated, error of order h^2."""
    h, channel = 1e-4, Channel(1.0, float(from_observer))
    coarse, fine = (linearised(law, gains, channel, step).feedback(s, step) for step in (h, 0.5 * h))
    return 2.0 * fine - coarse
