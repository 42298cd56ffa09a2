"""Hold position and yaw: what is left is the response to the air. The reference of disturbance studies."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from plant.references.spec import ReferenceSpec, Track, blank, without_step


@dataclass(frozen=True, kw_only=True)
class Hover(ReferenceSpec):
    """Hold position and yaw."""

    kind: ClassVar[str] = "hover"

    def track(self, t: np.ndarray) -> Track:
        """Return the resting reference."""
        return without_step(blank(t.size))
