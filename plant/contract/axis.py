"""One law on one axis: fed with given inputs, or flown on an exact double integrator."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.law import Law
from plant.records import pack, size

Array = NDArray[np.float64]
LOOPS = ("position", "attitude")
H = 0.004
REST = Setpoint(0.0, 0.0, 0.0)


class Input(NamedTuple):
    """Arguments of a law's step besides its memory, gains and channel."""

    setpoint: Setpoint
    measured: Measured
    applied: Applied


@dataclass(frozen=True)
class Trajectory:
    """Values y and rates (K,), commands before and after clipping (K,), memory after the last period."""

    value: Array
    rate: Array
    unlimited: Array
    command: Array
    memory: Any


@dataclass(frozen=True)
class Axis:
    """The plant y'' = b0 (u + disturbance + drift t), |u| <= limit, with the command held over each period, and the drift too.

    from_observer: nothing measures the rate; the law is given the difference of y, as `plant.model.controller` gives it.
    is_aware: whether the law is given the clipped command; else it takes the unlimited one as delivered.
    """

    b0: float = 1.0
    limit: float = np.inf
    disturbance: float = 0.0
    from_observer: bool = False
    is_aware: bool = True
    drift: float = 0.0

    def fly(
        self,
        law: Law,
        gains: Any,
        steps: int,
        goal: Callable[[float], Setpoint],
        start: Measured | None = None,
        h: float = H,
    ) -> Trajectory:
        """Fly for `steps` periods, from rest at 0 by default."""
        y, v = start or Measured(0.0, 0.0)
        constants = law.prepare(gains, h)
        memory, channel, applied = law.start(constants, Measured(y, v), 0.0), self.channel, Applied(0.0, 0.0)
        rows: list[tuple[float, float, float, float]] = []
        last = y
        for k in range(steps):
            seen, last = Measured(y, (y - last) / h if self.from_observer else v), y
            unlimited, memory = law.step(memory, constants, channel, goal(k * h), seen, applied, h)
            command = min(max(unlimited, -self.limit), self.limit)
            applied = Applied(command, command - unlimited) if self.is_aware else Applied(unlimited, 0.0)
            rows.append((y, v, unlimited, command))
            acceleration = self.b0 * (command + self.disturbance + self.drift * k * h)
            y, v = y + h * v + 0.5 * h * h * acceleration, v + h * acceleration
        value, rate, wanted, clipped = np.array(rows).T
        return Trajectory(value, rate, wanted, clipped, memory)

    @property
    def channel(self) -> Channel:
        """The axis in the law's model."""
        return Channel(self.b0, float(self.from_observer))


def defaults(law: Law, loop: str) -> Any:
    """Return the default gains of a law as a record."""
    return law.Gains(**law.defaults(loop))


def run(
    law: Law, gains: Any, inputs: list[Input], channel: Channel, h: float = H, memory: Any = None
) -> tuple[Array, Any]:
    """Feed given inputs, whatever the law commands; commands (K,) and the last memory. Starts at the first measurement."""
    constants = law.prepare(gains, h)
    memory = law.start(constants, inputs[0].measured, 0.0) if memory is None else memory
    commands: list[float] = []
    for setpoint, measured, applied in inputs:
        command, memory = law.step(memory, constants, channel, setpoint, measured, applied, h)
        commands.append(command)
    return np.array(commands), memory


def random_inputs(rng: np.random.Generator, count: int) -> list[Input]:
    """Return inputs of order one."""
    return [pack(Input, map(float, rng.standard_normal(size(Input)))) for _ in range(count)]
