"""The channel y'' = f + b0 u of a law: gain, setpoint, measurement and delivered command."""

from typing import NamedTuple


class Channel(NamedTuple):
    """The controller's knowledge of the channel that it acts on.

    b0: acceleration of y for one unit of u (1/I for an attitude axis with u in N m, 1 for a position axis with u in m/s2).
    rate_from_observer: 0 where a sensor measures the rate of y (gyro, velocity); 1 where none does, and a law with an observer or
    a filter of its own takes the rate from that. A law without one takes `Measured.rate` either way.
    """

    b0: float
    rate_from_observer: float


class Setpoint(NamedTuple):
    """Reference of y with its first and second derivative (rad or m, per s, per s2)."""

    value: float
    rate: float
    acceleration: float


class Measured(NamedTuple):
    """Measured y and its rate: a sensor's, or y differenced over the law's step where no sensor measures it (0 at the start)."""

    value: float
    rate: float


class Applied(NamedTuple):
    """The delivered part of the last commands, in units of u.

    effect: mean over the last period of what the actuators delivered, as modelled (clipped, lagged, delayed). excess: the
    last command after clipping minus the command asked for; 0 where nothing saturates.
    """

    effect: float
    excess: float
