"""Disturbance of the vehicle from outside during one control period."""

from typing import NamedTuple

from plant.vectors import Vec3


class Disturbance(NamedTuple):
    """Disturbance of a vehicle at an instant.

    Attributes:
        wind: air velocity, world ENU [m/s].
        gust_rate: rotation of the air, body FLU [rad/s].
        acceleration: injected, world ENU [m/s2].
        angular_acceleration: injected, body FLU [rad/s2].
    """

    wind: Vec3
    gust_rate: Vec3
    acceleration: Vec3
    angular_acceleration: Vec3
