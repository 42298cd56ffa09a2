"""A theorem applied to axes of a cascade: from gains rows to its numbers, and to requirements on them."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from plant.laws.law import Law
from plant.quadrotor.cascade import POSITION_AXES, Cascade
from plant.quadrotor.gains import gain_addresses
from tuner.extensions.theory.theorems.theorem import Array, Setting, Theorem


def loop_of(axis: str) -> str:
    """Return the loop of an axis: "position" or "attitude"."""
    return "position" if axis in POSITION_AXES else "attitude"


def law_of(cascade: Cascade, axis: str) -> Law:
    """Return the law that flies an axis."""
    return cascade.position if axis in POSITION_AXES else cascade.attitude


def channel_gains(cascade: Cascade, axis: str, rows: Array) -> Any:
    """Return the gains of one axis from gains rows (n, gains).

    They are a record of its law whose leaves are arrays (n,).
    """
    return law_of(cascade, axis).Gains(*[rows[:, gain.column] for gain in gain_addresses(cascade) if gain.axis == axis])


@dataclass(frozen=True)
class Guarantee:
    """A theorem on axes of a cascade, each in its setting."""

    theorem: Theorem
    cascade: Cascade
    settings: dict[str, Setting]

    def values(self, rows: Array) -> Array:
        """Return the theorem's number for gains rows (n, gains) on each axis (n, axes)."""
        return np.stack([self._value(axis, setting, rows) for axis, setting in self.settings.items()], axis=1)

    def worst(self, rows: Array) -> Array:
        """Return the number of the worst axis (n, 1)."""
        pick = np.max if self.theorem.sense == "max" else np.min
        return pick(self.values(rows), axis=1, keepdims=True)

    def _value(self, axis: str, setting: Setting, rows: Array) -> Array:
        value = self.theorem.values[law_of(self.cascade, axis).name]
        return value(channel_gains(self.cascade, axis, rows), setting)
