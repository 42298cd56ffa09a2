"""Steady states that loops are judged in: hover, and trims in a wind or at a speed."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from plant.quadrotor.nominal import Nominal
from plant.quadrotor.trim import SteadyFlight, trim_of, within_limits
from plant.quadrotor.vehicle import Vehicle
from plant.vectors import Vec3

if TYPE_CHECKING:
    from objectives.margins.trim import Trim

HOVER = "hover"
"""Name of the state in still air."""


@dataclass(frozen=True)
class SteadyState:
    """A steady state that loops are judged in.

    Args:
        name: Name in words, unique among the states of a study.
        yaw: Heading [rad].
        velocity: Velocity over ground [m/s], world ENU.
        wind: Mean wind [m/s], world ENU.
        hold: Whether the loops of x and y are closed.
        is_diagonal: Whether the air comes from between the axes of the body.
    """

    name: str
    yaw: float = 0.0
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    wind: tuple[float, float, float] = (0.0, 0.0, 0.0)
    hold: bool = True
    is_diagonal: bool = False

    @cached_property
    def trim(self) -> "Trim":
        """The trim that margins are linearized about."""
        # Here, because a study that asks for no margins needs no CasADi.
        from objectives.margins.trim import Trim

        return Trim(self.yaw, Vec3(*self.velocity), Vec3(*self.wind), self.hold)

    @property
    def moves(self) -> bool:
        """True if air moves past the vehicle."""
        return self.wind != self.velocity

    def flight(self, vehicle: Vehicle) -> SteadyFlight:
        """Return the balance of a vehicle, rows of one."""
        return trim_of(vehicle, np.subtract(self.wind, self.velocity).tolist(), self.yaw)

    def can_hold(self, vehicle: Vehicle, nominal: Nominal) -> bool:
        """Return True if a controller can hold a vehicle in this state."""
        return bool(within_limits(self.flight(vehicle), nominal)[0])
