"""PID gains of a user's plant, by the convex-concave procedure.

The loop is taken as it is sampled.
L of a channel with PID, all others closed, is linear in kp, ki and kd, whatever the plant: so its three parts are read off the
margin model, and `pid_ccp` makes ki kp^speed large while |S| and |T| keep their limits. Inner channels come first, and outer
ones act through them. A solution counts if the sampled loop is stable and satisfies the limits on a finer grid.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from math import inf, isfinite

import numpy as np

from objectives.design.pid_ccp import POINTS, PidTask, Procedure, discs
from objectives.design.requirements import DesignRequirements
from objectives.margins.plant_margins import PlantMargins
from objectives.plant_system import PlantSystem
from plant.laws import pid
from plant.model.plan import Channel

Array = np.ndarray

# Frequencies start at this share of that of Nyquist.
LOWEST = 1e-4
# Factors of the gains that a design starts from: of all three, and of kp and kd apart. A plant that is unstable by itself takes
# the second ones: at small gains its loop satisfies Ms and Mt, and is as unstable as the plant.
SMALLER, LARGER = (1.0, 0.5, 0.25, 0.1, 0.05, 0.02, 0.01), (1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0)
SHAPES = (tuple((factor,) * 3 for factor in SMALLER), tuple((p, 1.0, d) for p, d in product(LARGER, LARGER)))
# Share of a peak's room above 1 that is used on the frequencies of the design, so that it keeps its limit between them too.
ROOM = 0.99
# What stands for a derivative gain of 0, as a share of kp times a control period.
NOTHING = 1e-6
DESIGNED = ("kp", "ki", "kd")
NO_START = (
    "from 0.01 to 1000 times the default gains, within their ranges and the actuator's, no loop is stable within Ms and Mt; "
    "give wider ranges, larger limits or a default that stabilizes the plant"
)


@dataclass(frozen=True)
class ChannelDesign:
    """Design of a channel, or why there is none; ms, mt: peaks of the sampled loop found afterwards."""

    designed: bool
    why: str
    ms: float = inf
    mt: float = inf


@dataclass(frozen=True)
class ChannelTask:
    """A channel that is to be designed.

    Attributes:
        low: Lower ends of the ranges of all gains (g,).
        high: Upper ends (g,), equal to the lower one where a gain is fixed.
        noise: RMS of its output and of its rate (2,).
        step: Largest step of its set point, 0 for none.
        authority: Largest command it may ask for, infinite for none [unit of the command].
    """

    channel: Channel
    low: Array
    high: Array
    noise: tuple[float, float]
    step: float
    authority: float


def design_channels(
    system: PlantSystem, row: Array, tasks: Mapping[str, ChannelTask], requirements: DesignRequirements
) -> tuple[Array, dict[str, ChannelDesign]]:
    """Return the designed gains row (g,), and the result of each channel.

    Only channels that can be designed change. row: where to start.
    """
    row, designs = np.array(row, dtype=float), {}
    for channel in reversed(system.plan.channels):
        row, designs[channel.name] = _design(system, row, tasks[channel.name], requirements)
    return row, {name: designs[name] for name in system.plan.names}


def _design(
    system: PlantSystem, row: Array, task: ChannelTask, requirements: DesignRequirements
) -> tuple[Array, ChannelDesign]:
    law, columns = task.channel.law, _columns(system, task.channel)
    if law.family != pid.FAMILY:
        return row, ChannelDesign(False, f"there is no designer for the law '{law.name}' on a plant of one's own")
    if any(channel.every > 1 for channel in system.plan.channels):
        return row, ChannelDesign(
            False, "channels step at several rates, and a design takes those that all step together"
        )
    if not (task.high[columns[:2]] > 0.0).all():
        return row, ChannelDesign(False, "kp and ki must be above 0; give them ranges")
    shaped = _pid_task(system, row, task, requirements)
    procedure, used = Procedure(shaped), _used(row, columns, system)
    for factors in SHAPES:
        starts = np.unique(np.clip(np.array(factors) * used, shaped.low, shaped.high), axis=0)
        settled = [procedure.settle(start) for start in starts if procedure.keeps(start)]
        for gains in sorted(settled, key=procedure.merit, reverse=True):
            tried = row.copy()
            tried[columns] = np.clip(gains, task.low[columns], task.high[columns])
            design = _judged(system, tried, task.channel.name, requirements)
            if design is not None:
                return tried, design
    return row, ChannelDesign(False, NO_START)


def loop_parts(system: PlantSystem, row: Array, channel: Channel, omega: Array) -> Array:
    """Return the parts (k, 3) of L by kp, ki and kd.

    L is that of a channel as sampled, at frequencies (k,) [rad/s].
    """
    columns, rows = _columns(system, channel), []
    used = _used(row, columns, system)
    for column, size in zip(columns, used, strict=True):
        alone = row.copy()
        alone[columns] = 0.0
        alone[column] = size
        model = PlantMargins(system, 0.9 * alone, 1.1 * alone)
        t = model.loop(alone, channel.name, frequency=omega).t
        rows.append(-t / (1.0 + t) / size)
    return np.stack(rows, axis=1)


def _pid_task(system: PlantSystem, row: Array, task: ChannelTask, requirements: DesignRequirements) -> PidTask:
    nyquist = np.pi / system.timing.control_period
    parts = loop_parts(system, row, task.channel, np.geomspace(LOWEST * nyquist, nyquist, POINTS))
    low, high = _ends(task, _columns(system, task.channel), system)
    most = task.authority * abs(task.channel.b0)
    if task.step > 0.0 and isfinite(most):
        high[0] = max(min(high[0], most / task.step), low[0])
    noise = np.diag(task.noise) / (requirements.noise * most) if isfinite(most) else np.zeros((2, 2))
    tighter = replace(requirements, ms=1.0 + ROOM * (requirements.ms - 1.0), mt=1.0 + ROOM * (requirements.mt - 1.0))
    return PidTask(parts, discs(tighter), noise, inf, requirements.speed, low, high)


def _judged(system: PlantSystem, row: Array, name: str, requirements: DesignRequirements) -> ChannelDesign | None:
    margins = PlantMargins(system, 0.9 * row, 1.1 * row).evaluate(row[None])
    i = margins.channels.index(name)
    ms, mt = float(margins.sensitivity.value[0, i]), float(margins.complementary.value[0, i])
    if not margins.stable[0, i] or ms > requirements.ms or mt > requirements.mt:
        return None
    return ChannelDesign(True, "load rejection as large as the limits allow", ms, mt)


def _columns(system: PlantSystem, channel: Channel) -> list[int]:
    columns = {gain.address: gain.column for gain in system.gains}
    return [columns[f"{channel.name}.{name}"] for name in DESIGNED if f"{channel.name}.{name}" in columns]


def _used(row: Array, columns: list[int], system: PlantSystem) -> Array:
    """Return (kp, ki, kd) of a row, none of them 0."""
    kp, ki, kd = row[columns]
    return np.array([kp, ki, max(kd, NOTHING * kp * system.timing.control_period)])


def _ends(task: ChannelTask, columns: list[int], system: PlantSystem) -> tuple[Array, Array]:
    low, high = task.low[columns].copy(), task.high[columns].copy()
    least = NOTHING * high[0] * system.timing.control_period
    return np.maximum(low, [0.0, 0.0, min(least, NOTHING)]), np.maximum(high, [0.0, 0.0, least])
