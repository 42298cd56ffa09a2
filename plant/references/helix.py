"""A circle that climbs: steady centripetal acceleration and vertical speed; climb_rate = 0 gives the plain circle."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from plant.references.blend import along, phase
from plant.references.parameters import number
from plant.references.spec import ReferenceSpec, Track, motion


@dataclass(frozen=True, kw_only=True)
class Helix(ReferenceSpec):
    """Circle about (-radius, 0) with steady climb, counter-clockwise seen from above, started from rest at the origin.

    It gains pace over the first period; from then on it makes a turn per period and climbs at climb_rate.
    """

    kind: ClassVar[str] = "helix"

    radius: float = number("m", "radius of the circle", above=0.0)
    period: float = number("s", "time of one round at full pace", above=0.0)
    climb_rate: float = number("m/s", "vertical speed at full pace; negative descends", default=0.0)

    def track(self, t: np.ndarray) -> Track:
        """Return the motion with its analytic velocity and acceleration."""
        angle = phase(t, self.period)
        a, zero, radius = angle.angle, np.zeros(t.size), self.radius
        climb = self.climb_rate * self.period / (2.0 * np.pi)  # height per radian
        p = np.column_stack((radius * (np.cos(a) - 1.0), radius * np.sin(a), climb * a))
        dp = np.column_stack((-radius * np.sin(a), radius * np.cos(a), zero + climb))
        ddp = np.column_stack((-radius * np.cos(a), -radius * np.sin(a), zero))
        return motion(*along(p, dp, ddp, angle))
