"""Usual limits of every loop, in the units of study files.

They hold unless a study has others.
Source: gain margin 6 dB either way after MIL-F-9490D; K. J. Astrom, R. M. Murray, Feedback Systems, 2nd ed., Princeton 2021,
section 10.3 (phase 30 to 60 deg) and section 12.2 (Ms 1.2 to 2). A critically damped PD law with linear extended state observer
cannot reach 45 deg below wo/wc = 7, hence 35 deg as the limit and 45 deg as the target; two control periods of delay are what a
late sample and a late command cost together.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class LoopLimit:
    """A limit of one quantity of every loop.

    Attributes:
        quantity: Name in `objectives.margins.quantities`.
        sense: "min" or "max".
        limit: Limit in the unit of limits.
        target: Value to reach besides, None for nothing more.
    """

    quantity: str
    sense: str
    limit: float
    target: float | None = None

    def is_satisfied(self, value: float) -> bool:
        """True if a value keeps the limit."""
        return _keeps(value, self.limit, self.sense)

    def reached(self, value: float) -> bool:
        """True if a value reaches the target, or else the limit."""
        return _keeps(value, self.limit if self.target is None else self.target, self.sense)

    @property
    def text(self) -> str:
        """Limit in words, the target in brackets."""
        return f"{self.sense} {self.limit:g}" + ("" if self.target is None else f" ({self.target:g})")


def _keeps(value: float, limit: float, sense: str) -> bool:
    return value >= limit if sense == "min" else value <= limit


LIMITS = (
    LoopLimit("gain_up", "min", 6.0),
    LoopLimit("gain_down", "min", 6.0),
    LoopLimit("phase_margin", "min", 35.0, target=45.0),
    LoopLimit("delay_periods", "min", 2.0),
    LoopLimit("ms", "max", 2.0, target=1.7),
)
