"""What gains.json stands for."""

from dataclasses import dataclass

from plant.airframes import Airframe
from plant.cascade import Cascade
from plant.nominal import ControlOptions


@dataclass(frozen=True)
class Controller:
    """A controller ready to fly: the airframe it is for, its cascade, options, periods [s] and gains in column order."""

    airframe: Airframe
    cascade: Cascade
    options: ControlOptions
    control_period: float
    plant_step: float
    gains: tuple[float, ...]
