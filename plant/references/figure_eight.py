"""A horizontal figure eight: sustained, smoothly changing acceleration on x and y; the usual test of tracking."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from plant.references.blend import along, phase
from plant.references.parameters import number
from plant.references.spec import ReferenceSpec, Track, motion


@dataclass(frozen=True, kw_only=True)
class FigureEight(ReferenceSpec):
    """Horizontal figure eight, x = size sin(a), y = (size / 2) sin(2 a), started from rest in its middle.

    The lemniscate of Gerono; the angle a gains pace over the first period and then makes a turn per period.
    """

    kind: ClassVar[str] = "figure_eight"

    size: float = number("m", "half its length, along x; it is half as wide as long", above=0.0)
    period: float = number("s", "time of one round at full pace", above=0.0)

    def track(self, t: np.ndarray) -> Track:
        """Return the motion with its analytic velocity and acceleration."""
        angle = phase(t, self.period)
        a, zero, size = angle.angle, np.zeros(t.size), self.size
        p = np.column_stack((size * np.sin(a), 0.5 * size * np.sin(2.0 * a), zero))
        dp = np.column_stack((size * np.cos(a), size * np.cos(2.0 * a), zero))
        ddp = np.column_stack((-size * np.sin(a), -2.0 * size * np.sin(2.0 * a), zero))
        return motion(*along(p, dp, ddp, angle))
