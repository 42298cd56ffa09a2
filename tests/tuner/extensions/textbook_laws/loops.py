"""Loops of textbooks: a linear plant under one channel, flown in Python, and what a step answer has in a table."""

from dataclasses import replace
from typing import Any, NamedTuple

import control
import numpy as np

from objectives.plant_system import PlantSystem
from plant.law_registry import LAWS
from plant.model.plan import Actuator, Channel
from plant.model.scenario import PlantScenario
from plant.model.signals import Signal, Step
from tests.plant.model.plants import stepped
from tuner.api.plants import plant_system


class Answer(NamedTuple):
    """Times, outputs and commands (K,) of a flight."""

    t: np.ndarray
    y: np.ndarray
    u: np.ndarray

    @property
    def overshoot(self) -> float:
        """Per cent of the last value."""
        return 100.0 * (self.y.max(axis=0) / self.y[-1] - 1.0)

    def settling(self, band: float = 0.02) -> float:
        """Time from which on the output stays within a share of its last value."""
        outside = np.abs(self.y / self.y[-1] - 1.0) > band
        return float(self.t[np.nonzero(outside)[0][-1] + 1])

    @property
    def rise(self) -> float:
        """Time from 10 to 90 % of the last value."""
        share = self.y / self.y[-1]
        return float(self.t[np.argmax(share > 0.9)] - self.t[np.argmax(share > 0.1)])


def loop_of(
    numerator: list[float],
    denominator: list[float],
    law: str,
    h: float,
    limits: tuple[float, float] | None = None,
    **rest: Any,
) -> PlantSystem:
    """Return a transfer function under one channel "y" that acts on "u"."""
    channel = Channel("y", LAWS[law], "y", "u", **rest)
    actuators = [] if limits is None else [Actuator("u", *limits)]
    return plant_system(control.tf(numerator, denominator), "plant", [channel], actuators, control_period=h)


def with_actuator(system: PlantSystem, actuator: Actuator) -> PlantSystem:
    """Return the same loop behind another actuator."""
    return replace(system, plan=replace(system.plan, actuators=(actuator,)))


def row_of(system: PlantSystem, **gains: float) -> np.ndarray:
    """Return the gains of the channel as a row; optional ones have their defaults."""
    values = {gain.info.name: gain.default for gain in system.gains if gain.info.optional} | gains
    return np.array([values[gain.info.name] for gain in system.gains])


def answer(
    system: PlantSystem, duration: float, signal: Signal | None = None, load: Signal | None = None, /, **gains: float
) -> Answer:
    """Fly a channel through a step of its set point, by default of 1 at once."""
    loads = {} if load is None else {"u_load": load}
    spec = PlantScenario("step", duration, {"y": Step(1.0, 0.0) if signal is None else signal}, loads)
    drawn = system.sample(spec, 1, "step", [0])
    rows, _ = stepped(system, row_of(system, **gains), drawn)
    names = [*system.plant.State._fields, *system.plant.Input._fields, *system.plant.Output._fields]
    y, u = rows[:, names.index("y")], rows[:, names.index("u")]
    return Answer(system.timing.control_period * np.arange(len(y)), y, u)
