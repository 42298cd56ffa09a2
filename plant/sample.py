"""Sample of a flight at one control instant, as the meters see it."""

from typing import NamedTuple

from plant.vectors import Rotors


class AxisSample(NamedTuple):
    """Reference and true value of one axis, m or rad; where an axis is not tracked, both are the same."""

    reference: float
    actual: float


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
