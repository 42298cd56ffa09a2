"""Forming processes of the Dryden turbulence: linear filters whose outputs have the Dryden spectra.

Axes: u along the mean wind (downwind), v horizontal and to the left of u, w up. The rates are those of the air, seen as
a rigid body, about these axes: dw/du = -q, dv/du = +r. The field drifts downwind past the vehicle, so d/du = -(1/V)
d/dt, q = +(dw/dt)/V and r = -(dv/dt)/V: q shares the noise of w with sign +, r that of v with sign -, both lagged by
the span; p has noise of its own. (Editions of the specifications print other sign pairs for axes forward, right, down;
the coherence of 1 is common to all.)

    H_u = sigma sqrt(2 tau) / (1 + tau s),    H_v = H_w = sigma sqrt(tau) (1 + sqrt(3) tau s) / (1 + tau s)^2
    H_q = +(s/V) / (1 + T_q s) H_w,           H_r = -(s/V) / (1 + T_r s) H_v
    H_p = sigma_p sqrt(2 T_p) / (1 + T_p s)

for white noise of unit intensity, E[n(t) n(s)] = delta(t - s); the noise power pi of the printed filters is absorbed.
Every process here has sigma = 1: multiply after sampling. The rates are not validated below about 1 m of span.

Source: MIL-F-8785C (1980), 3.7; MIL-HDBK-1797 (1997), appendix A.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from plant.air.linear_process import LinearProcess, SampledProcess, discretize, gauss_markov
from plant.air.turbulence_field import TurbulenceField


class Dryden(NamedTuple):
    """The four independent processes at one step; outputs (u), (v, r), (w, q), (p) for sigma = 1 m/s (p: 1 rad/s)."""

    u: SampledProcess
    v: SampledProcess
    w: SampledProcess
    p: SampledProcess


def transverse(tau: float, rate_tau: float, gradient: float) -> LinearProcess:
    """Return the cascade of a transverse gust and its gradient, a gust rate.

    Args:
        tau: correlation time [s].
        rate_tau: lag of the rate [s].
        gradient: signed 1/V [s/m], which turns the time derivative into a rate.

    Outputs: the gust [m/s] with unit variance, the rate [rad/s] that belongs to it. States: two lags of tau, since H
    = K (sqrt(3) / (1 + tau s) + (1 - sqrt(3)) / (1 + tau s)^2), then the rate's lag.
    """
    first, second = sqrt(3.0 * tau), (1.0 - sqrt(3.0)) * sqrt(tau)
    a = np.array(
        [
            [-1.0 / tau, 0.0, 0.0],
            [1.0 / tau, -1.0 / tau, 0.0],
            [first / rate_tau, second / rate_tau, -1.0 / rate_tau],
        ]
    )
    rate = np.array([first, second, -1.0]) * (gradient / rate_tau)
    return LinearProcess(a, np.array([1.0 / tau, 0.0, 0.0]), np.array([[first, second, 0.0], rate]))


def forming(field: TurbulenceField, dt: float) -> Dryden:
    """Return the exact samplers of the field at a step dt [s]."""
    tau_u, tau_v, tau_w = field.tau
    tau_p, tau_q, tau_r = field.rate_tau
    gradient = 1.0 / field.airspeed
    return Dryden(
        u=discretize(gauss_markov(tau_u), dt),
        v=discretize(transverse(tau_v, tau_r, -gradient), dt),
        w=discretize(transverse(tau_w, tau_q, gradient), dt),
        p=discretize(gauss_markov(tau_p), dt),
    )
