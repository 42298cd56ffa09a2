"""Which part of an axis is shown: everything of interest, on a logarithmic axis where it covers decades."""

from collections.abc import Iterable
from math import ceil, floor, log10
from typing import Any, NamedTuple

import numpy as np

from tuner.text.numbers import significant

PADDING = 0.06
# Where the shown values span more than this factor, a linear axis would press most of them into a corner.
LOG_FACTOR = 25.0


class Span(NamedTuple):
    """Ends of an axis in the unit of its quantity."""

    low: float
    high: float
    log: bool

    def plotly(self) -> dict[str, Any]:
        """Return the attributes of a plotly axis."""
        if self.log:
            # Every number in full: plotly.js writes 0.2 and 2 alike as "2".
            texts = {"tickvals": self.ticks(), "ticktext": [significant(value) for value in self.ticks()], "nticks": 0}
            return {"type": "log", "range": np.log10([self.low, self.high]).tolist(), **texts}
        return {"range": [self.low, self.high]}

    def ticks(self) -> list[float]:
        """Return round numbers inside a logarithmic span: the fewer in a decade, the more decades there are."""
        decades = log10(self.high / self.low)
        digits = (1.0, 2.0, 5.0) if decades < 1.7 else (1.0, 3.0) if decades < 3.5 else (1.0,)
        powers = range(floor(log10(self.low)), ceil(log10(self.high)) + 1)
        values = [digit * 10.0**power for power in powers for digit in digits]
        return [value for value in values if self.low <= value <= self.high]


def span_of(parts: Iterable[np.ndarray], log_factor: float = LOG_FACTOR) -> Span:
    """Return a span that holds all finite values of some arrays, with a little air around them.

    log_factor: logarithmic where they are positive and span more than this factor.
    """
    values = np.concatenate([np.asarray(part, dtype=float).ravel() for part in parts] or [np.zeros(0)])
    values = values[np.isfinite(values)]
    if len(values) == 0:
        return Span(0.0, 1.0, False)
    low, high = float(values.min(axis=0)), float(values.max(axis=0))
    if low > 0.0 and high > log_factor * low:
        stretch = (high / low) ** PADDING
        return Span(low / stretch, high * stretch, True)
    margin = PADDING * (high - low) or 0.1 * abs(high) or 1.0
    return Span(low - margin, high + margin, False)
