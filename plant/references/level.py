"""Hold roll, pitch and yaw at zero with x and y left free: what the attitude loops alone do against the air.

The reference of attitude studies such as Wu et al. 2025, section 3, figures 7, 9 and 11. Altitude is still held.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from plant.references.spec import HOLD, ReferenceSpec, Track, blank, without_step


@dataclass(frozen=True, kw_only=True)
class Level(ReferenceSpec):
    """Hold a level attitude and yaw 0 in attitude mode (hold = 0)."""

    kind: ClassVar[str] = "level"

    def track(self, t: np.ndarray) -> Track:
        """Return the resting reference in attitude mode."""
        samples = blank(t.size)
        samples[:, HOLD] = 0.0
        return without_step(samples)
