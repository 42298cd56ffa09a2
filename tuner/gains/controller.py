"""Controller that a gains.json describes, and the parts of the file that tell of it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, Self

from objectives.margins.steady_state import SteadyState
from plant.law_registry import law
from plant.quadrotor.airframes import Airframe
from plant.quadrotor.cascade import Cascade, close_cascade
from plant.quadrotor.nominal import ControlOptions
from tuner.gains.quantities import plain
from tuner.gains.sections import Row


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
    """A controller ready to fly: the airframe it is for, its cascade, options, periods [s], gains in column order, the vehicle
    that they were imported from, if any, and the steady states beside hover that its study judged it in.
    """

    airframe: Airframe
    cascade: Cascade
    options: ControlOptions
    control_period: float
    plant_step: float
    gains: tuple[float, ...]
    vehicle: VehicleRecord | None = None
    states: tuple[SteadyState, ...] = ()


class ControllerPart(NamedTuple):
    """Laws and periods [s] of a file that the schema accepts; given: its options by name, in the units of `ControlOptions`."""

    position: str
    attitude: str
    control_period: float
    plant_step: float
    position_every: int
    given: Row

    @classmethod
    def of(cls, block: Row) -> Self:
        """Return the part of a file at the key "controller"."""
        content: Row = {"position_every": 1, **plain(block)}
        given = {name: content[name] for name in ControlOptions.__dataclass_fields__ if name in content}
        return cls(**{name: content[name] for name in cls._fields[:-1]}, given=given)

    @property
    def cascade(self) -> Cascade:
        """Cascade of the laws."""
        return close_cascade(law(self.position), law(self.attitude), self.position_every)

    @property
    def options(self) -> ControlOptions:
        """Options; raises InputError where one is out of range."""
        return ControlOptions(**self.given)
