"""Move at a constant rate for a while: shows how far a loop lags behind a motion reference and how it stops."""

from dataclasses import dataclass
from math import radians
from typing import ClassVar

import numpy as np

from plant.errors import InputError
from plant.references.blend import blend
from plant.references.parameters import number
from plant.references.spec import ReferenceSpec, Track, motion


@dataclass(frozen=True, kw_only=True)
class Ramp(ReferenceSpec):
    """Constant rate of one or several axes between two times, with smooth changes of pace.

    The axis ends at rate (stop - start), reached at stop + blend.
    """

    kind: ClassVar[str] = "ramp"

    x_rate: float = number("m/s", "speed to the east", default=0.0)
    y_rate: float = number("m/s", "speed to the north", default=0.0)
    z_rate: float = number("m/s", "speed upwards", default=0.0)
    yaw_rate_deg: float = number("deg/s", "rate of yaw", default=0.0)
    start: float = number("s", "when the motion begins", default=1.0, low=0.0)
    stop: float = number("s", "when it begins to end", above=0.0)
    blend: float = number("s", "time to reach the rate, and to lose it", default=0.5, above=0.0)

    def __post_init__(self) -> None:
        """Check the numbers, and their order."""
        super().__post_init__()
        if not np.any(self._rates()):
            raise InputError("no axis moves; give one of x_rate, y_rate, z_rate, yaw_rate_deg, or kind = 'hover'")
        if self.stop <= self.start:
            raise InputError(f"is {self.stop:g} s; it must be after start = {self.start:g} s", key="stop")

    def track(self, t: np.ndarray) -> Track:
        """Return the motion with its analytic rates and accelerations."""
        on, off = blend(t, self.start, self.blend), blend(t, self.stop, self.blend)
        parts = (on.integral - off.integral, on.share - off.share, on.rate - off.rate)
        position, velocity, acceleration = (np.outer(part, self._rates()) for part in parts)
        return motion(position[:, :3], velocity[:, :3], acceleration[:, :3], position[:, 3], velocity[:, 3])

    def _rates(self) -> np.ndarray:
        return np.array([self.x_rate, self.y_rate, self.z_rate, radians(self.yaw_rate_deg)])
