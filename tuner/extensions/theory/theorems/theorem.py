"""The type of a theorem: a number that follows from the gains of one channel, and its use."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plant.laws.law import in_loop

Array = NDArray[np.float64]


class Setting(NamedTuple):
    """Input of a theorem besides the gains.

    period: of control [s]. rate: bound on |d'| of the channel's total disturbance, y'' = d + b0 u [y/s3].
    """

    period: float
    rate: float


Value = Callable[[Any, Setting], Array]
"""From a channel's gains, a record of the law's type whose leaves are arrays (n,), to the number (n,)."""


@dataclass(frozen=True)
class Theorem:
    """One result that can be required of gains.

    Attributes:
        quantity: Meaning of the number, one line.
        unit: Unit of the number, with {y} for the unit of the channel.
        sense: "max" where less is better (bounds on errors), "min" where more is (the fastest disturbance that is
            borne: to be held against the rate of the disturbance).
        values: Functions by the names of the laws that it speaks of.
        needs_rate: Whether the number depends on `Setting.rate`.
        measured_rate: Whether it holds only where the law takes measured rates, not its observer's.
        assumes: Further conditions on the loop, one line.
    """

    name: str
    title: str
    source: str
    quantity: str
    unit: str
    sense: str
    values: Mapping[str, Value]
    needs_rate: bool
    measured_rate: bool
    assumes: str

    @property
    def laws(self) -> tuple[str, ...]:
        """Names of the laws that it speaks of."""
        return tuple(self.values)

    def unit_in(self, loop: str) -> str:
        """Return the unit in the loop "attitude" (y in rad) or "position" (y in m)."""
        return in_loop(self.unit, loop)

    def speaks_of(self, law: str, rate_from_observer: bool) -> bool:
        """Return True if it covers a law with that source of rate.

        law: its name. The rate is from its observer or as measured.
        """
        return law in self.values and not (self.measured_rate and rate_from_observer)
