"""Interface of a target that can fly an experiment."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from plant.quadrotor.vehicle import Vehicle
from tuner.extensions.flight_plans.choosing import TargetCapabilities
from tuner.extensions.flight_plans.excitation import Excitation, halved
from tuner.extensions.flight_plans.flying import SimulatedVehicle

HALF = "half_"
"""Prefix of the files with half the amplitude."""
HALF_FIRST = (
    f"Fly the files {HALF}* first, with half of every amplitude, and feel the motors: they may be warm, not hot."
)


@dataclass(frozen=True)
class ExcitationTarget:
    """A target that can fly an experiment.

    Attributes:
        capabilities: Excitations that it can fly.
        files: Function of excitations and simulated vehicle: relative name -> content.
        notes: A sentence each, on how to fly it and what differs from the simulated flight.
    """

    name: str
    capabilities: TargetCapabilities
    files: Callable[[Sequence[Excitation], SimulatedVehicle], Mapping[str, bytes]]
    notes: tuple[str, ...]

    def all_files(self, excitations: Sequence[Excitation], simulated: SimulatedVehicle) -> dict[str, bytes]:
        """Return the files of a plan and those with half the amplitude."""
        half = self.files(halved(excitations), simulated)
        return {**self.files(excitations, simulated), **{f"{HALF}{name}": content for name, content in half.items()}}


def throttle_share(acceleration: float, vehicle: Vehicle) -> float:
    """Return the share of the full thrust that accelerates a vehicle [m/s2]."""
    return acceleration * vehicle.mass / (4.0 * vehicle.thrust_coefficient * vehicle.speed_max**2)
