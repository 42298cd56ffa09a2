"""The margin quantities: one table of names, units and meanings for requirements, files, tables and drawings.

Files hold a quantity under its name in its SI `unit`: rad, s, rad/s, gains as factors. It is drawn and printed in `shown_unit`,
and a study file limits it in `limit_unit`: dB for gains, deg for phases, else SI. A loop that is not stable has 1 as its gain
margins, 0 of whatever else should be large and an infinite peak, so every allowed limit refuses it.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from objectives.margins.classical import MAX_GAIN_DB
from objectives.scales import DECIBEL, DEGREES, MILLISECONDS, Scale
from plant.quadrotor.cascade import AXES

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MarginQuantity:
    """One margin quantity of a loop.

    Attributes:
        name: Name in every file.
        label: Label in tables and drawings.
        short: Label in narrow tables.
        unit: Unit of files, SI, "1" for factors and ratios.
        sense: "min" where more is better, "max" where less is.
        field: Field of the record `Margins` that it is read from.
        meaning: One line for reports.
        scale: Unit in which it is shown, where that is not the unit of files.
        limited: Unit in which a study file limits it, where that is not the unit of files.
        digits: Behind the point where it is printed.
        low: Above which limits have a sense, in the unit of limits; None where no limit can be put on it.
        high: Below which limits have a sense, in the unit of limits.
        unlimited: Meaning of an infinite value of a stable loop.
        unstable: Value of a loop that is not stable.
        open: Value of a channel without any loop.
        read: Function of margins that returns the values, where they are computed from several fields.
        other_fields: All of these but `field`.
        is_multiloop: One value (n,) of all loops at once.
    """

    name: str
    label: str
    short: str
    unit: str
    sense: str
    field: str
    meaning: str
    scale: Scale | None = None
    limited: Scale | None = None
    digits: int = 2
    low: float | None = 0.0
    high: float = np.inf
    unlimited: str = ""
    unstable: float = 0.0
    open: float = np.inf
    read: Callable[[Any], Array] | None = None
    other_fields: tuple[str, ...] = ()
    is_multiloop: bool = False

    @property
    def fields(self) -> tuple[str, ...]:
        """Fields of the record `Margins` that its values come from."""
        return (self.field, *self.other_fields)

    def infinite_text(self, otherwise: str) -> str:
        """Return an infinite value as text: gains are looked at up to 50 dB."""
        return f">{MAX_GAIN_DB:g}" if self.scale is DECIBEL else otherwise

    @property
    def shown_unit(self) -> str:
        """Unit in which it is drawn and printed."""
        return self.unit if self.scale is None else self.scale.unit

    @property
    def limit_unit(self) -> str:
        """Unit of its limits in study files."""
        return self.unit if self.limited is None else self.limited.unit

    def shown(self, value: Any) -> Any:
        """Return a file's value in the unit of drawings and prints."""
        return value if self.scale is None else self.scale.shown(value)

    def to_limit(self, value: Any) -> Any:
        """Return a value of a file in the unit of limits."""
        return value if self.limited is None else self.limited.shown(value)

    def from_limit(self, value: Any) -> Any:
        """Return a value in the unit of limits as files hold it."""
        return value if self.limited is None else self.limited.si(value)

    def values(self, margins: Any) -> Array:
        """Return the values (n, channels) of a record `Margins`, in files' unit.

        They are (n,) where `is_multiloop`.
        """
        return getattr(margins, self.field).value if self.read is None else self.read(margins)

    def worst(self, values: Array, axes: Iterable[str], channels: tuple[str, ...] = AXES) -> Array:
        """Return each candidate's value (n,) in the worst of some axes.

        values: (n, channels), in any unit.
        """
        if self.is_multiloop:
            return values
        chosen = values[:, [channels.index(axis) for axis in axes]]
        return np.min(chosen, axis=1) if self.sense == "min" else np.max(chosen, axis=1)


CROSSES_NOWHERE = "the loop gain crosses 1 nowhere"

QUANTITIES = {
    entry.name: entry
    for entry in (
        MarginQuantity(
            "gain_margin", "gain margin", "gain", "1", "min", "gain_up",
            "how far the loop gain may change, the lesser of up and down",
            DECIBEL, DECIBEL, 1, high=MAX_GAIN_DB,
            read=lambda margins: np.minimum(margins.gain_up.value, margins.gain_down.value),
            other_fields=("gain_down",),
        ),
        MarginQuantity(
            "gain_up", "gain margin up", "gain up", "1", "min", "gain_up",
            "how far the loop gain may rise",
            DECIBEL, DECIBEL, 1, high=MAX_GAIN_DB,
            unlimited=f"no rise of the gain up to {MAX_GAIN_DB:g} dB makes it unstable", unstable=1.0,
        ),
        MarginQuantity(
            "gain_down", "gain margin down", "gain down", "1", "min", "gain_down",
            "how far the loop gain may fall",
            DECIBEL, DECIBEL, 1, high=MAX_GAIN_DB,
            unlimited=f"no fall of the gain up to {MAX_GAIN_DB:g} dB makes it unstable", unstable=1.0,
        ),
        MarginQuantity(
            "phase_margin", "phase margin", "phase", "rad", "min", "phase",
            "phase, lag or lead, that the loop bears at its gain crossovers",
            DEGREES, DEGREES, 1, high=180.0, unlimited=CROSSES_NOWHERE,
        ),
        MarginQuantity(
            "delay_margin", "delay margin", "delay", "s", "min", "delay",
            "delay that the loop bears besides its own", MILLISECONDS, digits=1, unlimited=CROSSES_NOWHERE,
        ),
        MarginQuantity(
            "delay_periods", "delay margin in control periods", "delay in periods", "1", "min", "delay",
            "delay margin in control periods",
            digits=1, unlimited=CROSSES_NOWHERE, read=lambda margins: margins.delay_periods,
        ),
        MarginQuantity(
            "ms", "peak sensitivity Ms", "Ms, peak of S", "1", "max", "sensitivity",
            "peak of the sensitivity, Ms; 1/Ms is the distance of the loop from -1",
            low=1.0, unstable=np.inf, open=1.0,
        ),
        MarginQuantity(
            "mt", "peak complementary sensitivity Mt", "Mt, peak of T", "1", "max", "complementary",
            "peak of the complementary sensitivity, Mt", unstable=np.inf, open=0.0,
        ),
        MarginQuantity(
            "disk", "disk margin", "disk margin", "1", "min", "disk",
            "disk margin alpha: gain and phase at once, one loop at a time",
            high=2.0, unlimited="nothing limits it",
        ),
        MarginQuantity(
            "multiloop_disk", "disk margin of all loops", "disk margin", "1", "min", "multiloop",
            "disk margin alpha in z, roll, pitch and yaw at once", high=2.0, is_multiloop=True,
        ),
        MarginQuantity(
            "crossover", "gain crossover", "crossover", "rad/s", "max", "crossover",
            "highest gain crossover", low=None, open=0.0,
        ),
        MarginQuantity(
            "group_delay", "group delay at crossover", "group delay", "s", "max", "group_delay",
            "delay of the whole chain, filters and lags included, where the loop gain is 1",
            MILLISECONDS, digits=1, unstable=np.inf, open=0.0,
        ),
        MarginQuantity(
            "rejection", "disturbance rejection bandwidth", "rejection", "rad/s", "min", "rejection",
            "frequency up to which disturbances are rejected by 3 dB or more; their peak is Ms", open=0.0,
        ),
        MarginQuantity(
            "bandwidth", "bandwidth", "bandwidth", "rad/s", "min", "bandwidth",
            "frequency up to which the reference is followed to within -3 dB", open=0.0,
        ),
        MarginQuantity(
            "load_index", "load index", "load", "s^-3", "min", "load_index",
            "load-disturbance index k_i: acceleration per integrated error", open=0.0,
        ),
    )
}  # fmt: skip
"""Every quantity by name. Gain, phase and delay margins are infinite where no crossing limits them."""

LOOP_QUANTITIES = tuple(entry for entry in QUANTITIES.values() if entry.read is None and not entry.is_multiloop)
"""Quantities that are read from each loop's own curves: one field of `Margins` each."""

LIMITABLE = {name: entry for name, entry in QUANTITIES.items() if entry.low is not None}
"""Quantities that a `[[margin]]` table of a study may limit, by name."""

RECORDED = ("gain_up", "gain_down", "phase_margin", "delay_margin", "ms", "mt", "disk", "crossover", "bandwidth")
"""Names of the quantities of each loop in gains.json and margins.npz."""

REPORTED = (
    "gain_up", "gain_down", "phase_margin", "delay_margin", "delay_periods", "ms", "mt", "disk", "group_delay", "rejection",
    "bandwidth", "load_index",
)  # fmt: skip
"""Names of the quantities of each loop that `tuner margins` and `tuner design` report."""
