"""Sample of a quadrotor's flight for meters, and the targets of its axes."""

from typing import NamedTuple

from plant.sample import AxisSample, Target
from plant.vectors import Rotors


class Sample(NamedTuple):
    """One control instant t = k h.

    time [s]; six axes (for roll and pitch the reference is the attitude that the cascade asks for); command and previous:
    rotor thrust commands after clipping over the hover thrust of one rotor, now and one period ago; saturated: 1 where any
    rotor stands at a limit, else 0.
    """

    time: float
    x: AxisSample
    y: AxisSample
    z: AxisSample
    roll: AxisSample
    pitch: AxisSample
    yaw: AxisSample
    command: Rotors
    previous: Rotors
    saturated: float


class Targets(NamedTuple):
    """Targets of the six axes."""

    x: Target
    y: Target
    z: Target
    roll: Target
    pitch: Target
    yaw: Target
