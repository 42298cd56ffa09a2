"""A channel of a plant of the user's own in continuous time: plant, actuators and all laws as one linear state space.

The plant is linearized where it rests, by exact derivatives. Its inputs come late by their delay and half a control period of
hold, a Pade approximant of order 2, and lag; laws stand in their continuous form (`Law.continuous`), with the rate that is
measured or the difference of two values. Everything that does not act on the channel is left out. Commands are within all limits.

A proof about a channel holds where its assumptions do; `refused` names the first that does not.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from objectives.linear_axis.channel_model import (
    MODELLED,
    WITH_SECTOR,
    Factors,
    RotorLag,
    StateSpace,
    controller,
    dead_time,
)
from objectives.plant_system import PlantSystem
from plant.model.plan import Actuator, Channel
from plant.model.slope import linear_equations
from plant.records import pack, paths

Array = np.ndarray

# Order of the Pade approximants, and the most by which the distances from -1, 1/Ms, as sampled and in continuous time may differ
# where the one loop speaks for the other.
ORDER, ALIKE = 2, 0.05
# Frequencies at which a sensitivity is looked at, from this share of Nyquist on.
POINTS, LOWEST = 2000, 1e-5


@dataclass(frozen=True)
class PlantAxis:
    """A channel of a plant under a gains row (g,): what a certificate is asked about.

    disturbance: what pushes, a field of the plant's Disturbance or an input.
    """

    system: PlantSystem
    row: tuple[float, ...]
    name: str
    disturbance: str

    @property
    def channel(self) -> Channel:
        """The channel."""
        return self.system.plan.channel(self.name)

    @property
    def law(self) -> str:
        """Name of its law."""
        return self.channel.law.name

    @property
    def gains(self) -> Any:
        """Gains of its law."""
        return gains_of(self.system, self.row, self.name)

    @property
    def acts_on_input(self) -> bool:
        """True if its command goes to an input, not to another channel."""
        return not self.system.plan.cascades(self.channel)

    @cached_property
    def gain(self) -> float:
        """Immediate acceleration of the output for a unit of u.

        It is 1 where b0 is right, and 0 where the input moves no acceleration.
        """
        plant, plan = _linear(self.system), self.system.plan
        if not self.acts_on_input:
            return 0.0
        force = [actuator.name for actuator in plan.actuators].index(self.channel.to)
        output = paths(self.system.plant.Output).index(self.channel.output)
        c, b = plant.c[output], plant.b[:, force]
        return 0.0 if plant.d[output, force] or c @ b else float(c @ plant.a @ b) / self.channel.b0

    def closed(self, factors: Factors) -> StateSpace:
        """Return the loop from `channel_model.INPUTS` to OUTPUTS; the true inertia over the nominal one divides its command."""
        return self._loop_and_others(factors)[0]

    def refused(self, peak: float) -> str:
        """Return the first failed assumption of a proof in words, or "".

        peak: Ms of the loop as sampled.
        """
        plan = self.system.plan
        if not self.system.has_equations:
            return "the plant is an FMU, which does not show its equations"
        if plan.observer is not None:
            return "channels read an observer, which no proof models"
        if any(channel.every > 1 for channel in plan.channels):
            return "channels step at several rates; a proof takes those that all step together"
        if self.law not in MODELLED:
            return f"the law '{self.law}' has no continuous form"
        _, others = self._loop_and_others(Factors())
        if others:
            return f"channel '{others[0]}' acts on it and is not linear; a proof takes one law that is not"
        if not np.isfinite(peak):
            return "the loop as sampled is not stable"
        mine = self.peak()
        if abs(1.0 / mine - 1.0 / peak) > ALIKE:
            return (
                f"Ms is {peak:.3g} as sampled and {mine:.3g} in continuous time, where it is proved: too far apart for a proof "
                "to speak of what flies; take a shorter control period"
            )
        return ""

    def peak(self) -> float:
        """Return Ms of the loop, broken where margins break it.

        That is where the command goes to the plant or to another channel.
        """
        goes = f"w {self.channel.to}", f"felt {self.channel.to}"
        sources, targets = goes if self.acts_on_input else (f"r {self.channel.to}", f"c {self.name}")
        loop = interconnection(self.system, self.row, {}).between([sources], [targets])
        nyquist = np.pi / self.system.timing.control_period
        w = np.geomspace(LOWEST * nyquist, nyquist, POINTS)
        return float(np.abs(1.0 + loop.at(1j * w)[:, 0, 0]).max(axis=0))

    def _loop_and_others(self, factors: Factors) -> tuple[StateSpace, list[str]]:
        """Return the loop, and the other channels that act on it nonlinearly."""
        plan = self.system.plan
        pushed = [
            channel.name
            for channel in plan.channels
            if channel.law.name not in MODELLED or (channel.name != self.name and channel.law.name in WITH_SECTOR)
        ]
        sources = [f"r {self.name}", f"w {self.disturbance}", f"phi {self.name}", *[f"phi {name}" for name in pushed]]
        targets = [f"y {self.name}", f"v {self.name}", f"c {self.name}", f"S {self.name}"]
        loop = acting_on_outputs(interconnection(self.system, self.row, {self.name: factors}).between(sources, targets))
        acting = [name for i, name in enumerate(pushed, 3) if loop.b[:, i].any() or loop.d[:, i].any()]
        return StateSpace(loop.a, loop.b[:, :3], loop.c, loop.d[:, :3]), acting


@dataclass(frozen=True)
class Interconnection:
    """Blocks that are connected by the names of their signals.

    Their inputs follow from their outputs and from given signals.

    Attributes:
        blocks: State space of each block.
        inputs: Summands of each input of a block, by signal with its factor.
        outputs: Names of the outputs, in the order of the blocks.
    """

    blocks: Sequence[StateSpace]
    inputs: Sequence[dict[str, float]]
    outputs: Sequence[str]

    def between(self, sources: Sequence[str], targets: Sequence[str]) -> StateSpace:
        """Return the closed loop from given signals to outputs; unspecified inputs are zero."""
        a, b, c, d = (block_diag(*[getattr(block, name) for block in self.blocks]) for name in "abcd")
        back, outside = self._matrix(self.outputs), self._matrix(sources)
        inward = np.linalg.inv(np.eye(len(self.inputs)) - back @ d)
        by_state, by_given = inward @ back @ c, inward @ outside
        rows = [self.outputs.index(name) for name in targets]
        return StateSpace(a + b @ by_state, b @ by_given, (c + d @ by_state)[rows], (d @ by_given)[rows])

    def _matrix(self, names: Sequence[str]) -> Array:
        return np.array([[parts.get(name, 0.0) for name in names] for parts in self.inputs])


def interconnection(system: PlantSystem, row: Sequence[float], factors: dict[str, Factors]) -> Interconnection:
    """Return all blocks of a plant's loops; factors: of the channels whose commands act with another gain than assumed.

    Signals: w of a disturbance or an input, r and phi of a channel (what is added to its set point and taken off its command),
    and as outputs y, v, c, u and S of a channel: output, its rate, command with phi taken off [its unit] and without, surface.
    """
    plan, plant = system.plan, system.plant
    commands = {
        channel.name: {f"c {channel.name}": 1.0 / factors.get(channel.name, Factors()).inertia}
        for channel in plan.channels
    }
    moving = _linear(system)
    blocks = [_with_rates(moving)]
    outputs = [f"{kind} {name}" for kind in ("out", "rate") for name in paths(plant.Output)]
    inputs: list[dict[str, float]] = [{f"felt {each.name}": 1.0, f"w {each.name}": 1.0} for each in plan.actuators]
    inputs += [{f"w {name}": 1.0} for name in paths(plant.Disturbance)]
    for actuator in plan.actuators:
        blocks.append(_way(actuator, system.timing.control_period))
        outputs += [f"felt {actuator.name}", f"known {actuator.name}"]
        inputs.append(_sum(commands[each.name] for each in plan.acting_on(actuator.name)))
    for channel in plan.channels:
        name, outer = channel.name, plan.commanded.get(channel.name)
        value, (rate, seen) = {f"out {channel.output}": 1.0}, _rate(system, channel, moving)
        applied = f"c {name}" if plan.cascades(channel) else f"known {channel.to}"
        blocks += [_law(system, row, channel), _through(), _through(), seen]
        outputs += [f"u {name}", f"S {name}", f"c {name}", f"y {name}", f"v {name}"]
        goal = {f"r {name}": 1.0, **({} if outer is None else {f"c {outer}": 1.0})}
        inputs += [goal, value, {f"v {name}": 1.0}, {applied: channel.b0}]
        inputs += [{f"u {name}": 1.0 / channel.b0, f"phi {name}": -1.0 / channel.b0}, value, {rate: 1.0}]
    return Interconnection(blocks, inputs, outputs)


def acting_on_outputs(loop: StateSpace) -> StateSpace:
    """Return a state space without states that reach no output, even indirectly."""
    felt = loop.c.any(axis=0)
    for _ in range(len(loop.a)):
        felt = felt | loop.a[felt].any(axis=0)
    return StateSpace(loop.a[np.ix_(felt, felt)], loop.b[felt], loop.c[:, felt], loop.d)


def gains_of(system: PlantSystem, row: Sequence[float], name: str) -> Any:
    """Return the Gains of a channel's law in a gains row."""
    return getattr(pack(system.loop.records.Gains, list(map(float, row))), name)


def _linear(system: PlantSystem) -> StateSpace:
    """Return the plant where it rests, from inputs and disturbances to outputs."""
    return StateSpace(*linear_equations(system.plant, system.parameters))


def _law(system: PlantSystem, row: Sequence[float], channel: Channel) -> StateSpace:
    """Return a law from (r, y, v, known) to (u, S); one without a continuous form does nothing, and phi represents it."""
    if channel.law.name not in MODELLED:
        return StateSpace(np.zeros((0, 0)), np.zeros((0, 4)), np.zeros((2, 0)), np.zeros((2, 4)))
    return controller(channel.law.name, gains_of(system, row, channel.name), channel.rate_output is None)


def _way(actuator: Actuator, control_period: float) -> StateSpace:
    """Return the transfer of a command to (the plant, the model of the laws)."""
    delay = actuator.delay + 0.5 * control_period
    if actuator.lag > 0.0:
        return RotorLag(actuator.lag, delay, lag_aware=False, order=ORDER).model(Factors())
    late = dead_time(delay, ORDER)
    return StateSpace(late.a, late.b, np.tile(late.c, (2, 1)), np.tile(late.d, (2, 1)))


def _with_rates(plant: StateSpace) -> StateSpace:
    """Return a plant with the rates of its outputs behind them; of one that answers at once it is only of its other part."""
    c, d = np.concatenate([plant.c, plant.c @ plant.a], axis=0), np.concatenate([plant.d, plant.c @ plant.b], axis=0)
    return StateSpace(plant.a, plant.b, c, d)


def _rate(system: PlantSystem, channel: Channel, plant: StateSpace) -> tuple[str, StateSpace]:
    """Return the plant output of a law's rate, and its processing: measured, its own, or a difference of values.

    Differencing and the filter behind it, as sampled, are together about as late as the filter alone in continuous time, so the
    rate itself represents the difference, where there is one.
    """
    if channel.rate_output is not None:
        return f"out {channel.rate_output}", _through()
    if plant.d[paths(system.plant.Output).index(channel.output)].any():
        return f"out {channel.output}", _differenced(system.timing.control_period)
    return f"rate {channel.output}", _through()


def _differenced(control_period: float) -> StateSpace:
    """Return the difference of two values a period h [s] apart, over h."""
    late = dead_time(control_period, ORDER)
    return StateSpace(late.a, late.b, -late.c / control_period, (1.0 - late.d) / control_period)


def _through() -> StateSpace:
    return dead_time(0.0, 0)


def _sum(parts: Any) -> dict[str, float]:
    return {name: factor for part in parts for name, factor in part.items()}
