"""One instant of a reference, as kernels read it."""

from typing import NamedTuple

from plant.vectors import Vec3

AXES: tuple[str, ...] = ("x", "y", "z", "roll", "pitch", "yaw")


class Reference(NamedTuple):
    """Position [m], velocity [m/s], acceleration [m/s2] in world ENU; roll, pitch, yaw [rad]; yaw_rate [rad/s]; hold.

    hold is 1 where the position loop tracks x and y, and 0 in attitude mode: roll and pitch are then tracked as given, x and y
    are free, and altitude is still held.
    """

    position: Vec3
    velocity: Vec3
    acceleration: Vec3
    roll: float
    pitch: float
    yaw: float
    yaw_rate: float
    hold: float
