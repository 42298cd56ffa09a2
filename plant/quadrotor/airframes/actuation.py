"""Conversion of torque to an autopilot's normalised units: rotor places, largest thrust, thrust curve, hover command, lag."""

from dataclasses import dataclass
from math import sqrt

from plant.quadrotor.vehicle import Vehicle


@dataclass(frozen=True)
class RotorMount:
    """One rotor: position in body FLU from the centre of mass [m]; spin +1 where its reaction torque is about +z (up), i.e. the
    propeller turns clockwise seen from above; torque per thrust [m].
    """

    x: float
    y: float
    spin: float
    torque_ratio: float


@dataclass(frozen=True)
class Actuation:
    """Thrust of the rotors over the motor command.

    Attributes:
        thrust_max, thrust_min of one rotor [N].
        hover_thrust: thrust of one rotor at hover [N].
        curve: f = 1 - thrust_linear of the thrust curve T = thrust_max (f u^2 + (1 - f) u) over the motor command u in
            0..1, 1 where the command sets the speed.
        lag: mean time constant of the rotor speed [s].
        rotors in our order (1 front left, 2 front right, 3 rear left, 4 rear right).
    """

    thrust_max: float
    thrust_min: float
    hover_thrust: float
    curve: float
    lag: float
    rotors: tuple[RotorMount, RotorMount, RotorMount, RotorMount]

    @property
    def hover_command(self) -> float:
        """Motor command at hover [1], in 0..1."""
        share, f = self.hover_thrust / self.thrust_max, self.curve
        if f <= 1e-9:
            return share
        return (f - 1.0 + sqrt((1.0 - f) ** 2 + 4.0 * f * share)) / (2.0 * f)

    @property
    def hover_slope(self) -> float:
        """Thrust per motor command at hover, dT/du [N]."""
        return self.thrust_max * (2.0 * self.curve * self.hover_command + 1.0 - self.curve)


def actuation(vehicle: Vehicle, curve: float | None = None) -> Actuation:
    """Work out the actuation of a vehicle; curve: see `Actuation`, by default that of the vehicle."""
    lag = 0.5 * (vehicle.lag_up + vehicle.lag_down)
    mounts = [
        RotorMount(x, y, spin, vehicle.torque_ratio)
        for x, y, spin in zip(vehicle.rotor_x, vehicle.rotor_y, vehicle.spin, strict=True)
    ]
    k_f = vehicle.thrust_coefficient
    return Actuation(
        k_f * vehicle.speed_max**2,
        k_f * vehicle.speed_min**2,
        0.25 * vehicle.mass * vehicle.gravity,
        1.0 - vehicle.thrust_linear if curve is None else curve,
        lag,
        (mounts[0], mounts[1], mounts[2], mounts[3]),
    )
