"""A step on one or several axes at one time: the reference of rise time, overshoot and settling.

Steps of x, y, z and yaw are tracked by the whole cascade. Steps of roll and pitch test the attitude loop alone: the
flight is then in attitude mode (hold = 0), in which x and y are free and altitude is still held.
"""

from dataclasses import dataclass
from math import radians
from typing import ClassVar

import numpy as np

from plant.errors import InputError
from plant.references.parameters import number
from plant.references.spec import HOLD, PITCH, POSITION, ROLL, YAW, ReferenceSpec, Track, blank


@dataclass(frozen=True, kw_only=True)
class Steps(ReferenceSpec):
    """Step of one or several axes at one time; roll or pitch puts the flight in attitude mode."""

    kind: ClassVar[str] = "steps"

    x: float = number("m", "step to the east", default=0.0)
    y: float = number("m", "step to the north", default=0.0)
    z: float = number("m", "step upwards", default=0.0)
    # 40 deg: half of where a flight counts as diverged, and a thrust to weight of 1.33 still holds altitude at 41 deg.
    roll_deg: float = number("deg", "step of roll (attitude mode)", default=0.0, low=-40.0, high=40.0)
    pitch_deg: float = number("deg", "step of pitch (attitude mode)", default=0.0, low=-40.0, high=40.0)
    yaw_deg: float = number("deg", "step of yaw", default=0.0, low=-180.0, high=180.0)
    time: float = number("s", "when the step happens, after the start", default=1.0, above=0.0)

    def __post_init__(self) -> None:
        """Check the numbers, and that the axes go together."""
        super().__post_init__()
        if not np.any(self._levels()):
            raise InputError("no axis steps; give one of x, y, z, roll_deg, pitch_deg, yaw_deg, or kind = 'hover'")
        for axis in ("x", "y"):
            if self._in_attitude_mode() and getattr(self, axis) != 0.0:
                raise InputError("cannot step with roll_deg or pitch_deg, which leave x and y free", key=axis)

    def track(self, t: np.ndarray) -> Track:
        """Return the two levels; InputError if the step happens after the last sample."""
        # 1e-9 s: a step at 0.0275 s belongs to sample 5 at 5.5 ms, although 5 * 0.0055 falls an ulp short of 0.0275.
        after = t >= self.time - 1e-9
        if not after[-1]:
            message = f"is {self.time:g} s, but the flight ends at {t[-1]:g} s; step earlier or fly longer"
            raise InputError(message, key="time")
        final = self._levels()
        samples = blank(t.size)
        samples[:, POSITION] = np.outer(after, final[:3])
        samples[:, [ROLL, PITCH, YAW]] = np.outer(after, final[3:])
        samples[:, HOLD] = 0.0 if self._in_attitude_mode() else 1.0
        return Track(samples, np.zeros(6), final, self.time)

    def _levels(self) -> np.ndarray:
        angles = (radians(angle) for angle in (self.roll_deg, self.pitch_deg, self.yaw_deg))
        return np.array([self.x, self.y, self.z, *angles])

    def _in_attitude_mode(self) -> bool:
        return self.roll_deg != 0.0 or self.pitch_deg != 0.0
