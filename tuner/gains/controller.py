"""Controller that a gains.json describes, and the parts of the file that tell of it."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple

from objectives.margins.steady_state import SteadyState
from plant.airframes import Airframe
from plant.cascade import Cascade, close_cascade
from plant.laws import law
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
    """The key "controller" of a file that the schema accepts, without units: periods [s], tilt limit [rad], cut-off [Hz]."""

    position: str
    attitude: str
    control_period: float
    plant_step: float
    tilt_limit: float
    attitude_rate: Any
    position_rate: Any
    lag_aware: bool
    delay: bool
    structure: Mapping[str, str]
    discretisation: Mapping[str, str]
    yaw_torque_cutoff: float = 0.0
    rpm_notches: int = 0
    rpm_notch_q: float = ControlOptions.rpm_notch_q
    rpm_notch_min: float = ControlOptions.rpm_notch_min
    battery_compensation: float = 0.0
    battery_cutoff: float = ControlOptions.battery_cutoff
    position_every: int = 1
    code: Mapping[str, Any] = MappingProxyType({})

    @property
    def cascade(self) -> Cascade:
        """Cascade of the laws."""
        return close_cascade(law(self.position), law(self.attitude), self.position_every)

    @property
    def options(self) -> ControlOptions:
        """Options; raises InputError where one is out of range."""
        return ControlOptions(**{name: getattr(self, name) for name in ControlOptions.__dataclass_fields__})
