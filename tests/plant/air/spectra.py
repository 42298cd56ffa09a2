"""Dryden spectra and autocovariances in closed form, against which sampled turbulence is tested.

All spectra are one-sided in the angular frequency omega [rad/s]: sigma^2 = int_0^inf Phi(omega) d omega. In Hz, as
Welch's method gives it, S(f) = 2 pi Phi(2 pi f). Source: as for `plant.air.turbulence_field`.
"""

from math import pi

import numpy as np

from plant.air.turbulence_field import TRANSVERSE_FACTOR


def phi_u(omega, field):
    """Return the spectrum of the longitudinal gust [m2/s2 per rad/s]."""
    length = field.length[0] / field.airspeed
    return field.sigma[0] ** 2 * 2.0 * length / pi / (1.0 + (length * omega) ** 2)


def phi_v(omega, field):
    """Return the spectrum of the lateral gust [m2/s2 per rad/s]."""
    return _transverse(omega, field.spec, field.sigma[1], field.length[1] / field.airspeed)


def phi_w(omega, field):
    """Return the spectrum of the vertical gust [m2/s2 per rad/s]."""
    return _transverse(omega, field.spec, field.sigma[2], field.length[2] / field.airspeed)


def phi_p(omega, field):
    """Return the spectrum of the roll gust rate [rad2/s2 per rad/s]."""
    length = TRANSVERSE_FACTOR[field.spec] * field.length[2]
    level = field.sigma[2] ** 2 / (field.airspeed * length) * 0.8 * (pi * length / (4.0 * field.span)) ** (1.0 / 3.0)
    return level / (1.0 + (4.0 * field.span * omega / (pi * field.airspeed)) ** 2)


def phi_q(omega, field):
    """Return the spectrum of the pitch gust rate, the gradient of w along the wind [rad2/s2 per rad/s]."""
    return _gradient(omega, field.airspeed, 4.0 * field.span) * phi_w(omega, field)


def phi_r(omega, field):
    """Return the spectrum of the yaw gust rate, the gradient of v along the wind [rad2/s2 per rad/s]."""
    return _gradient(omega, field.airspeed, 3.0 * field.span) * phi_v(omega, field)


def longitudinal_autocovariance(lag, sigma, tau):
    """Return E[u(t) u(t + lag)] = sigma^2 exp(-|lag| / tau) [m2/s2]; lag and tau in s."""
    return sigma**2 * np.exp(-np.abs(lag) / tau)


def transverse_autocovariance(lag, sigma, tau):
    """Return sigma^2 exp(-|lag| / tau) (1 - |lag| / (2 tau)) [m2/s2]: negative beyond 2 tau; lag and tau in s."""
    x = np.abs(lag) / tau
    return sigma**2 * np.exp(-x) * (1.0 - 0.5 * x)


def _transverse(omega, spec, sigma, length):
    factor = TRANSVERSE_FACTOR[spec]
    square = (factor * length * omega) ** 2
    return sigma**2 * factor * length / pi * (1.0 + 3.0 * square) / (1.0 + square) ** 2


def _gradient(omega, airspeed, size):
    return (omega / airspeed) ** 2 / (1.0 + (size * omega / (pi * airspeed)) ** 2)
