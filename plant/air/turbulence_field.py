"""Turbulence field: lengths and standard deviations of one specification, met at one airspeed.

Lengths are in metres in the convention of the named specification: MIL-HDBK-1797 halves the 8785C lengths of v and w and
doubles them again in its formulas, so each formula must meet its own length.

Source: MIL-F-8785C (1980), 3.7; MIL-HDBK-1797 (1997), appendix A. Frozen field (Taylor): valid where sigma
is much smaller than the airspeed.
"""

from math import pi
from typing import NamedTuple

# What multiplies the length of v and w in each specification's formulas.
TRANSVERSE_FACTOR = {"8785C": 1.0, "1797": 2.0}
SPECS = tuple(TRANSVERSE_FACTOR)


class TurbulenceField(NamedTuple):
    """One stationary turbulence field met at one airspeed.

    spec: "8785C" or "1797". airspeed [m/s]. length [m] and sigma [m/s] of u, v, w. span [m]: rotor to rotor, or wing
    tip to tip.
    """

    spec: str
    airspeed: float
    length: tuple[float, float, float]
    sigma: tuple[float, float, float]
    span: float

    @property
    def tau(self) -> tuple[float, float, float]:
        """Correlation times of u, v, w [s]."""
        factor = TRANSVERSE_FACTOR[self.spec]
        u, v, w = self.length
        return u / self.airspeed, factor * v / self.airspeed, factor * w / self.airspeed

    @property
    def rate_tau(self) -> tuple[float, float, float]:
        """Lags of the gust rates p, q, r [s]: gusts shorter than the span do not turn the vehicle."""
        long = 4.0 * self.span / (pi * self.airspeed)
        return long, long, 0.75 * long

    @property
    def roll_rate_sigma(self) -> float:
        """Standard deviation of p [rad/s], from the integral of its spectrum."""
        length = TRANSVERSE_FACTOR[self.spec] * self.length[2]
        shape = (pi * length / (4.0 * self.span)) ** (1.0 / 6.0)
        return self.sigma[2] * shape * pi * (0.1 / (length * self.span)) ** 0.5
