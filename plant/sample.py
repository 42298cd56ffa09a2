"""One axis of a flight: its sample at a control instant, and the constants that its metrics are measured against."""

from typing import NamedTuple


class AxisSample(NamedTuple):
    """Reference and true value of one axis, m or rad; where an axis is not tracked, both are the same."""

    reference: float
    actual: float


class Target(NamedTuple):
    """One axis, in m or rad and s.

    Attributes:
        start, final: step levels r0 and r1 (equal where the axis makes no step).
        time: when the step happens.
        band: half-width of the settling band.
        recovery_from: when the gust or the gating window ends.
        recovery_band: half-width of the recovery band.
        steady_from: start of the window whose mean error is the steady-state error.
    """

    start: float
    final: float
    time: float
    band: float
    recovery_from: float
    recovery_band: float
    steady_from: float
