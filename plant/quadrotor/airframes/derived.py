"""Numbers derived from an airframe for control engineers (`tuner list airframes`)."""

from typing import NamedTuple

from plant.quadrotor.airframes.rules import hover_speed, thrust_to_weight
from plant.quadrotor.vehicle import Vehicle
from plant.vectors import Rotors


class DerivedNumber(NamedTuple):
    """A derived number, its SI unit ("1" where it has none) and what it means."""

    value: float
    unit: str
    meaning: str


def quantities(vehicle: Vehicle) -> dict[str, DerivedNumber]:
    """Return name -> DerivedNumber.

    The torques are the largest that can be had while total thrust stays at hover: rotors on one side go up and those on
    the other side down by the same thrust, as far as speed_min and speed_max let them.
    """
    hover = hover_speed(vehicle)
    swing = _thrust_swing(vehicle, hover)
    roll = swing * _absolute_sum(vehicle.rotor_y)
    pitch = swing * _absolute_sum(vehicle.rotor_x)
    yaw = swing * 4.0 * vehicle.torque_ratio
    inertia = vehicle.inertia
    return {
        "weight": DerivedNumber(vehicle.mass * vehicle.gravity, "N", "mass times gravity"),
        "hover_speed": DerivedNumber(hover, "rad/s", "rotor speed at hover"),
        "hover_thrust": DerivedNumber(vehicle.mass * vehicle.gravity / 4.0, "N", "thrust of one rotor at hover"),
        "thrust_to_weight": DerivedNumber(thrust_to_weight(vehicle), "1", "largest thrust over weight"),
        "roll_torque": DerivedNumber(roll, "N m", "largest roll torque at hover thrust"),
        "pitch_torque": DerivedNumber(pitch, "N m", "largest pitch torque at hover thrust"),
        "yaw_torque": DerivedNumber(yaw, "N m", "largest yaw torque at hover thrust"),
        "roll_acceleration": DerivedNumber(roll / inertia.x, "rad/s2", "largest roll acceleration at hover thrust"),
        "pitch_acceleration": DerivedNumber(pitch / inertia.y, "rad/s2", "largest pitch acceleration at hover thrust"),
        "yaw_acceleration": DerivedNumber(yaw / inertia.z, "rad/s2", "largest yaw acceleration at hover thrust"),
    }


def _thrust_swing(vehicle: Vehicle, hover: float) -> float:
    up = vehicle.speed_max**2 - hover**2
    down = hover**2 - vehicle.speed_min**2
    return vehicle.thrust_coefficient * min(up, down)


def _absolute_sum(levers: Rotors) -> float:
    return sum(abs(lever) for lever in levers)
