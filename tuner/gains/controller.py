"""Controller that a gains.json describes."""

from collections.abc import Mapping
from dataclasses import dataclass

from plant.airframes import Airframe
from plant.cascade import Cascade
from plant.nominal import ControlOptions


@dataclass(frozen=True)
class VehicleRecord:
    """The vehicle's parameter file that gains were imported from, as far as it speaks of the loops.

    target, target_version: as an exporter names them. file: its name without the folder. sha256: of its bytes (64 hex
    digits). settings: options of the import. parameters: name -> value in the target's unit. kept: names of those that our
    loops cannot carry; an export leaves them as the vehicle has them.
    """

    target: str
    target_version: str
    file: str
    sha256: str
    settings: Mapping[str, str]
    parameters: Mapping[str, float]
    kept: tuple[str, ...]


@dataclass(frozen=True)
class Controller:
    """A controller ready to fly: the airframe it is for, its cascade, options, periods [s], gains in column order, and the
    vehicle that they were imported from, if any.
    """

    airframe: Airframe
    cascade: Cascade
    options: ControlOptions
    control_period: float
    plant_step: float
    gains: tuple[float, ...]
    vehicle: VehicleRecord | None = None
