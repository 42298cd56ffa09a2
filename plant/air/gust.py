"""Discrete gust: one raised-cosine pulse of wind, the same in every scenario.

    wind(t) = amplitude / 2 (1 - cos(2 pi (t - start) / length)),    start <= t <= start + length, else 0

Use it to see one clean response next to the statistics. Source: the pulse of CS-25.341 (EASA), in time instead of gust
gradient distance. MIL-F-8785C, 3.7, has its first half only and then keeps the amplitude.
"""

from dataclasses import dataclass
from math import hypot, pi

import numpy as np
from numpy.typing import NDArray

from plant.air import checks

AXES = {"u": (1.0, 0.0, 0.0), "v": (0.0, 1.0, 0.0), "w": (0.0, 0.0, 1.0)}


@dataclass(frozen=True)
class Gust:
    """One pulse of wind.

    Attributes:
        amplitude: peak [m/s], may be negative.
        start [s].
        length: whole duration [s].
        direction: "u" (along the mean wind), "v" (horizontal, left of it) or "w" (up), which turn with the wind
            of each scenario; or three numbers, a direction in the world (ENU) of any length but 0.

    Raises InputError with a key "gust...".
    """

    amplitude: float
    start: float
    length: float
    direction: str | tuple[float, ...] = "u"

    def __post_init__(self) -> None:
        checks.number(self.amplitude, "gust.amplitude")
        checks.number(self.start, "gust.start", 0.0)
        checks.number(self.length, "gust.length", 0.0, above=True)
        if isinstance(self.direction, str):
            checks.name(self.direction, "gust.direction", "direction", tuple(AXES))
            return
        vector = checks.numbers(self.direction, "gust.direction", 3)
        checks.number(hypot(*vector), "gust.direction", 0.0, above=True)
        object.__setattr__(self, "direction", vector)


def gust_wind(time: NDArray[np.float64], gust: Gust) -> NDArray[np.float64]:
    """Return the gust's wind (K, 3) [m/s] in the axes of its direction."""
    vector = np.array(AXES[gust.direction] if isinstance(gust.direction, str) else gust.direction)
    phase = np.clip((time - gust.start) / gust.length, 0.0, 1.0)
    speed = 0.5 * gust.amplitude * (1.0 - np.cos(2.0 * pi * phase))
    return speed[:, None] * (vector / hypot(*vector))
