"""Margins as numbers that a limit can be put on: one number for each candidate, of the worst of some channels."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from objectives.margins.quantities import MarginQuantity
from objectives.requirements import Requirement

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MarginRequirement:
    """A limit on a quantity in the worst of some axes.

    Limit and values are in the quantity's unit of limits. On vanishing signals |s|^(1/2) sign s acts as an infinite
    gain, so a loop with it has margins from some amplitude on only, and oscillates below.

    Attributes:
        label: Its name.
        spread: True for the worst vehicle of the spread as well.
        amplitude: Smallest amplitude of the signals of nonlinear terms, each in its unit, that counts; 0 for all,
            vanishing ones and the steepest slope included.
        in_trims: True for the trims of the scenarios as well, not for hover alone.
    """

    quantity: MarginQuantity
    label: str
    axes: tuple[str, ...]
    limit: float
    hard: bool = True
    spread: bool = False
    amplitude: float = 0.0
    in_trims: bool = True

    def values(self, margins: Any) -> Array:
        """Return the number of each candidate (n,) of a record `Margins`."""
        return self.quantity.worst(self.quantity.to_limit(self.quantity.values(margins)), self.axes, margins.channels)

    @property
    def requirement(self) -> Requirement:
        """The same for `Problem`."""
        meaning = self.quantity.meaning
        if len(self.axes) > 1 and not self.quantity.is_multiloop:
            meaning += f"; worst of {', '.join(self.axes)}"
        if self.amplitude > 0.0:
            meaning += f"; nonlinear terms at amplitudes of {self.amplitude:g} and more"
        if self.spread:
            meaning += "; worst vehicle of the spread"
        quantity = self.quantity
        return Requirement(
            self.label, meaning, quantity.limit_unit, self.limit, quantity.sense, self.hard, quantity.limited
        )


def requirement_label(
    name: str,
    axis: str | None = None,
    *,
    hard: bool = True,
    spread: bool = False,
    amplitude: float = 0.0,
    in_trims: bool = True,
) -> str:
    """Return for instance "phase_margin(attitude, spread)"; "soft" sets a target apart from a hard limit on the same number."""
    words = [
        axis,
        f"from {amplitude:g}" if amplitude else None,
        None if in_trims else "hover",
        "spread" if spread else None,
        None if hard else "soft",
    ]
    listed = ", ".join(word for word in words if word)
    return f"{name}({listed})" if listed else name
