"""Gains, with the margin model of their airframe or plant."""

from dataclasses import dataclass

import numpy as np

from objectives.margins.loop_margins import LoopMargins
from objectives.margins.plant_margins import PlantMargins
from objectives.margins.quantities import MarginQuantity
from objectives.margins.results import Margins
from objectives.margins.trim import Trim
from objectives.plant_system import PlantSystem
from plant.loop import Timing
from plant.quadrotor.nominal import nominal
from tuner.gains import Controller
from tuner.study.margins import nominal_margins

Array = np.ndarray
# Share of the gains about them within which the structure of a plant's loops is looked at.
NEAR = 0.1


@dataclass(frozen=True)
class Loops:
    """Loops whose margins are judged: the gains row (g,) that closes them, their margin model, and the margins of that row."""

    row: Array
    model: LoopMargins
    margins: Margins

    @property
    def looped(self) -> tuple[str, ...]:
        """Channels that have a loop, in the order of the model."""
        closed = {channel for block in self.model.blocks for channel in block}
        return tuple(channel for channel in self.margins.channels if channel in closed)

    def place(self, channel: str) -> int:
        """Return the column of a channel in the margins."""
        return self.margins.channels.index(channel)

    def swept(self, channel: str) -> bool:
        """True if the loop of a channel depends on amplitude."""
        return bool(self.margins.sensitivity.case[0, self.place(channel)] >= 0)

    def value(self, quantity: MarginQuantity, channel: str) -> float:
        """Return a quantity of a loop in the unit of files."""
        return float(quantity.values(self.margins)[0, self.place(channel)])


@dataclass(frozen=True)
class Subject(Loops):
    """The loops of a quadrotor: controller and trim."""

    controller: Controller
    trim: Trim


@dataclass(frozen=True)
class PlantSubject(Loops):
    """The loops of a plant of the user's own, at rest."""

    system: PlantSystem


def subject_of(controller: Controller, trim: Trim) -> Subject:
    """Judge a controller on its own airframe; raises InputError where there is no steady flight in this trim."""
    vehicle, row = controller.airframe.vehicle, np.array(controller.gains)
    assumed = nominal(vehicle, controller.options, controller.control_period)
    timing = Timing(controller.control_period, controller.plant_step)
    model = nominal_margins(controller.cascade, assumed, timing, vehicle, trim, False)
    return Subject(row, model, model.evaluate(row[None]), controller, trim)


def plant_subject(system: PlantSystem, row: Array) -> PlantSubject:
    """Judge a gains row of a plant; raises InputError where its rates of channels have too long a common period."""
    model = PlantMargins(system, (1.0 - NEAR) * row, (1.0 + NEAR) * row)
    return PlantSubject(row, model, model.evaluate(row[None]), system)
