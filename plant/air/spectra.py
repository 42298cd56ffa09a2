"""Dryden spectra and autocovariances in closed form: what the sampled turbulence is tested and plotted against.

All spectra are one-sided in the angular frequency omega [rad/s]: sigma^2 = int_0^inf Phi(omega) d omega. In Hz, as
Welch's method gives it, S(f) = 2 pi Phi(2 pi f). Lengths are in metres in the convention of the named specification:
MIL-HDBK-1797 halves the 8785C lengths of v and w and doubles them again in its formulas, so each formula must meet its
own length.

Source: MIL-F-8785C (1980), 3.7; MIL-HDBK-1797 (1997), appendix A. Frozen field (Taylor): valid where sigma
is much smaller than the airspeed.
"""

from math import pi
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# One frequency or an array of them, answered in kind.
Real = TypeVar("Real", float, Array)

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


def phi_u(omega: Real, field: TurbulenceField) -> Real:
    """Return the spectrum of the longitudinal gust [m2/s2 per rad/s]."""
    length = field.length[0] / field.airspeed
    return field.sigma[0] ** 2 * 2.0 * length / pi / (1.0 + (length * omega) ** 2)


def phi_v(omega: Real, field: TurbulenceField) -> Real:
    """Return the spectrum of the lateral gust [m2/s2 per rad/s]."""
    return _transverse(omega, field.spec, field.sigma[1], field.length[1] / field.airspeed)


def phi_w(omega: Real, field: TurbulenceField) -> Real:
    """Return the spectrum of the vertical gust [m2/s2 per rad/s]."""
    return _transverse(omega, field.spec, field.sigma[2], field.length[2] / field.airspeed)


def phi_p(omega: Real, field: TurbulenceField) -> Real:
    """Return the spectrum of the roll gust rate [rad2/s2 per rad/s]."""
    length = TRANSVERSE_FACTOR[field.spec] * field.length[2]
    level = field.sigma[2] ** 2 / (field.airspeed * length) * 0.8 * (pi * length / (4.0 * field.span)) ** (1.0 / 3.0)
    return level / (1.0 + (4.0 * field.span * omega / (pi * field.airspeed)) ** 2)


def phi_q(omega: Real, field: TurbulenceField) -> Real:
    """Return the spectrum of the pitch gust rate, the gradient of w along the wind [rad2/s2 per rad/s]."""
    return _gradient(omega, field.airspeed, 4.0 * field.span) * phi_w(omega, field)


def phi_r(omega: Real, field: TurbulenceField) -> Real:
    """Return the spectrum of the yaw gust rate, the gradient of v along the wind [rad2/s2 per rad/s]."""
    return _gradient(omega, field.airspeed, 3.0 * field.span) * phi_v(omega, field)


def longitudinal_autocovariance(lag: float | Array, sigma: float, tau: float) -> Array:
    """Return E[u(t) u(t + lag)] = sigma^2 exp(-|lag| / tau) [m2/s2]; lag and tau in s."""
    return sigma**2 * np.exp(-np.abs(lag) / tau)


def transverse_autocovariance(lag: float | Array, sigma: float, tau: float) -> Array:
    """Return sigma^2 exp(-|lag| / tau) (1 - |lag| / (2 tau)) [m2/s2]: negative beyond 2 tau; lag and tau in s."""
    x = np.abs(lag) / tau
    return sigma**2 * np.exp(-x) * (1.0 - 0.5 * x)


def _transverse(omega: Real, spec: str, sigma: float, length: float) -> Real:
    factor = TRANSVERSE_FACTOR[spec]
    square = (factor * length * omega) ** 2
    return sigma**2 * factor * length / pi * (1.0 + 3.0 * square) / (1.0 + square) ** 2


def _gradient(omega: Real, airspeed: float, size: float) -> Real:
    return (omega / airspeed) ** 2 / (1.0 + (size * omega / (pi * airspeed)) ** 2)
