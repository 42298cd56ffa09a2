"""Han's tracking differentiator: a setpoint that jumps becomes one that moves with bounded acceleration.

    v1+ = v1 + h v2,   v2+ = v2 + h fhan(v1 - r, v2, r0, h0)

J. Han, IEEE Trans. Ind. Electron. 56(3), 2009. A step R is passed on within about 2 sqrt(R/r0), slow references with a delay of
2 h0. Written here about a reference that may move, with its rate and acceleration known: v - r is what is brought to rest, so
a reference that starts where v is passes unchanged, and one with r' = r'' = 0 meets Han's form.
"""

from typing import NamedTuple

from plant.laws.channel import Setpoint
from plant.laws.fhan import fhan


class Profile(NamedTuple):
    """v1 [y] and v2 [y/s]."""

    v1: float
    v2: float


def track(v: Profile, setpoint: Setpoint, r0: float, h0: float, h: float) -> tuple[Profile, Profile]:
    """Return the profile's current values and the next memory.

    v: the profile as foreseen for now. v1 is that; v2 carries what fhan makes of the setpoint, so that none of its news waits.
    """
    v2 = v.v2 + h * fhan(v.v1 - setpoint.value, v.v2 - setpoint.rate, r0, h0)
    ahead = v.v1 + h * v.v2 + 0.5 * h * h * setpoint.acceleration
    return Profile(v.v1, v2), Profile(ahead, v2 + h * setpoint.acceleration)
