"""Gains whose margins are judged, with the margin model of their airframe."""

from dataclasses import dataclass

import numpy as np

from objectives.margins.margins import MarginModel
from objectives.margins.period import CHANNELS
from objectives.margins.quantities import MarginQuantity
from objectives.margins.results import Margins
from objectives.margins.trim import Trim
from plant.loop import Timing
from plant.nominal import nominal
from tuner.gains import Controller

Array = np.ndarray


@dataclass(frozen=True)
class Subject:
    """Gains whose margins are judged: controller, trim, margin model of its airframe, and the margins of its row."""

    controller: Controller
    trim: Trim
    model: MarginModel
    margins: Margins

    @property
    def row(self) -> Array:
        """Gains row (g,)."""
        return np.array(self.controller.gains)

    @property
    def looped(self) -> tuple[str, ...]:
        """Channels that have a loop, in the order of `CHANNELS`."""
        closed = {channel for block in self.model.blocks for channel in block}
        return tuple(channel for channel in CHANNELS if channel in closed)

    def swept(self, channel: str) -> bool:
        """Whether the loop of a channel depends on amplitude."""
        return bool(self.margins.sensitivity.case[0, CHANNELS.index(channel)] >= 0)

    def value(self, quantity: MarginQuantity, channel: str) -> float:
        """Return a quantity of a loop in the unit of files."""
        return float(quantity.values(self.margins)[0, CHANNELS.index(channel)])


def subject_of(controller: Controller, trim: Trim) -> Subject:
    """Judge a controller on its own airframe; raises InputError where there is no steady flight in this trim."""
    vehicle = controller.airframe.vehicle
    known = nominal(vehicle, controller.options, controller.control_period)
    timing = Timing(controller.control_period, controller.plant_step)
    model = MarginModel(controller.cascade, known, timing, vehicle, trim)
    return Subject(controller, trim, model, model.evaluate(np.array([controller.gains])))
