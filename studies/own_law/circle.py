"""A circle in the plane, begun from rest."""

from dataclasses import dataclass
from math import pi
from typing import ClassVar

import numpy as np

from plant.references.parameters import number
from plant.references.spec import ACCELERATION, POSITION, VELOCITY, ReferenceSpec, Track, blank, without_step


@dataclass(frozen=True, kw_only=True)
class Circle(ReferenceSpec):
    """A circle in the horizontal plane through the start, at a pace that comes up smoothly in the first turn."""

    kind: ClassVar[str] = "circle"

    radius: float = number("m", "radius of the circle", default=1.0, above=0.0)
    period: float = number("s", "time of a turn at the full pace", default=5.0, above=0.0)

    def track(self, t: np.ndarray) -> Track:
        """Return the circle; its pace is (1 - cos(pi t/T))/2 of the full one in the first period T."""
        turn, ramp = 2.0 * pi / self.period, np.minimum(t / self.period, 1.0)
        pace = turn * 0.5 * (1.0 - np.cos(pi * ramp))
        gain = np.where(ramp < 1.0, turn * 0.5 * pi / self.period * np.sin(pi * ramp), 0.0)
        angle = turn * 0.5 * self.period * (ramp - np.sin(pi * ramp) / pi) + turn * np.maximum(t - self.period, 0.0)
        outward, onward = np.stack([np.cos(angle), np.sin(angle)], 1), np.stack([-np.sin(angle), np.cos(angle)], 1)
        samples = blank(t.size)
        samples[:, POSITION][:, :2] = self.radius * (outward - [1.0, 0.0])
        samples[:, VELOCITY][:, :2] = self.radius * pace[:, None] * onward
        samples[:, ACCELERATION][:, :2] = self.radius * (gain[:, None] * onward - pace[:, None] ** 2 * outward)
        return without_step(samples)


REFERENCE = Circle
