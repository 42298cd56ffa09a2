"""Tuned loops of a plant, with the study that holds its code."""

from dataclasses import dataclass

from tuner.study.plant_study import PlantStudy


@dataclass(frozen=True)
class PlantController:
    """A controller ready to run on its plant: the study that closes its loops, and the gains in column order."""

    study: PlantStudy
    gains: tuple[float, ...]
    vehicle: None = None
    """No vehicle's file records them."""
