"""Margins as numbers that a limit can be put on: one number for each candidate, of the worst of some channels.

Units are those in which limits are given and shown: dB for gains, deg for phases, else SI. A loop that is not stable has 0 of
whatever should be large and an infinite peak, so every allowed limit refuses it.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from objectives.requirements import Requirement
from plant.cascade import AXES

if TYPE_CHECKING:
    from objectives.margins.results import Margins

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MarginQuantity:
    """A number that a requirement may limit.

    unit: of values and limits. sense: "least" where more is better, "most" where less is. low, high: between which limits have
    a sense, neither included. read: Margins -> values (n, channels), or (n,) where `whole`, a quantity of all loops at once.
    meaning: one line for reports.
    """

    name: str
    unit: str
    sense: str
    low: float
    high: float
    read: Callable[["Margins"], Array]
    meaning: str
    whole: bool = False

    def values(self, margins: "Margins", axes: Iterable[str]) -> Array:
        """Return the number of each candidate (n,) in the worst of some axes."""
        values = self.read(margins)
        if self.whole:
            return values
        chosen = values[:, [AXES.index(axis) for axis in axes]]
        return np.min(chosen, axis=1) if self.sense == "least" else np.max(chosen, axis=1)


def _decibel(factor: Array) -> Array:
    from objectives.margins.results import decibel  # Here, because it brings CasADi along.

    return decibel(factor)


def _gain_margin(margins: "Margins") -> Array:
    return _decibel(np.minimum(margins.gain_up.value, margins.gain_down.value))


MARGINS = {
    entry.name: entry
    for entry in (
        MarginQuantity(
            "gain_margin", "dB", "least", 0.0, 80.0, _gain_margin,
            meaning="how far the loop gain may change, the lesser of up and down",
        ),
        MarginQuantity(
            "gain_up", "dB", "least", 0.0, 80.0, lambda margins: _decibel(margins.gain_up.value),
            meaning="how far the loop gain may rise",
        ),
        MarginQuantity(
            "gain_down", "dB", "least", 0.0, 80.0, lambda margins: _decibel(margins.gain_down.value),
            meaning="how far the loop gain may fall",
        ),
        MarginQuantity(
            "phase_margin", "deg", "least", 0.0, 180.0, lambda margins: np.degrees(margins.phase.value),
            meaning="phase, lag or lead, that the loop bears at its gain crossovers",
        ),
        MarginQuantity(
            "delay_margin", "s", "least", 0.0, np.inf, lambda margins: margins.delay.value,
            meaning="delay that the loop bears besides its own",
        ),
        MarginQuantity(
            "delay_periods", "1", "least", 0.0, np.inf, lambda margins: margins.delay_periods,
            meaning="delay margin in control periods",
        ),
        MarginQuantity(
            "ms", "1", "most", 1.0, np.inf, lambda margins: margins.sensitivity.value,
            meaning="peak of the sensitivity, Ms; 1/Ms is the distance of the loop from -1",
        ),
        MarginQuantity(
            "mt", "1", "most", 0.0, np.inf, lambda margins: margins.complementary.value,
            meaning="peak of the complementary sensitivity, Mt",
        ),
        MarginQuantity(
            "disk", "1", "least", 0.0, 2.0, lambda margins: margins.disk.value,
            meaning="disk margin alpha: gain and phase at once, one loop at a time",
        ),
        MarginQuantity(
            "multiloop_disk", "1", "least", 0.0, 2.0, lambda margins: margins.multiloop.value, whole=True,
            meaning="disk margin alpha in z, roll, pitch and yaw at once",
        ),
        MarginQuantity(
            "bandwidth", "rad/s", "least", 0.0, np.inf, lambda margins: margins.bandwidth.value,
            meaning="frequency up to which the reference is followed to within -3 dB",
        ),
        MarginQuantity(
            "load_index", "s^-3", "least", 0.0, np.inf, lambda margins: margins.load_index.value,
            meaning="load-disturbance index k_i: acceleration per integrated error",
        ),
    )
}  # fmt: skip
"""Every quantity by name. Gain, phase and delay margins are infinite where no crossing limits them."""


@dataclass(frozen=True)
class MarginRequirement:
    """A limit on a quantity in the worst of some axes, called `label`.

    spread: in the worst vehicle of the spread too. amplitude: smallest amplitude of the signals of nonlinear terms, each in its
    unit, that counts; 0 for all, vanishing ones and the steepest slope included. On vanishing signals |s|^(1/2) sign s acts as an
    infinite gain, so a loop with it has margins from some amplitude on only, and oscillates below.
    """

    quantity: MarginQuantity
    label: str
    axes: tuple[str, ...]
    limit: float
    hard: bool = True
    spread: bool = False
    amplitude: float = 0.0

    def values(self, margins: "Margins") -> Array:
        """Return the number of each candidate (n,)."""
        return self.quantity.values(margins, self.axes)

    @property
    def requirement(self) -> Requirement:
        """The same for `Problem`."""
        meaning = self.quantity.meaning
        if len(self.axes) > 1 and not self.quantity.whole:
            meaning += f"; worst of {', '.join(self.axes)}"
        if self.amplitude > 0.0:
            meaning += f"; nonlinear terms at amplitudes of {self.amplitude:g} and more"
        if self.spread:
            meaning += "; worst vehicle of the spread"
        return Requirement(self.label, meaning, self.quantity.unit, self.limit, self.quantity.sense, self.hard)


def requirement_label(
    name: str, axis: str | None = None, *, hard: bool = True, spread: bool = False, amplitude: float = 0.0
) -> str:
    """Return for instance "phase_margin(attitude, spread)"; "soft" sets a target apart from a hard limit on the same number."""
    words = [axis, f"from {amplitude:g}" if amplitude else None, "spread" if spread else None, None if hard else "soft"]
    said = ", ".join(word for word in words if word)
    return f"{name}({said})" if said else name
