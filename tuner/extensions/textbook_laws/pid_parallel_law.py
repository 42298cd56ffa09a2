"""Parallel PID with set-point weights: kp, ki and kd add up.

    b0 u = kp (b r - y) + I + D,    Tf D' + D = kd (c r - y)'
    I' = ki (r - y) + b0 (u_clipped - u)/(rho kp/ki),    clamping = 1: without ki (r - y) where it drives a limited u on

Use it for gains that a manual prints as Kp, Ki and Kd. Write c = 1 for D on the error, c = 0 for D on the measurement; b = 0 and
c = 0 is I-PD. Anti-windup: back-calculation for
tracking (rho) above 0, clamping for clamping = 1, none for both 0.

With b0 = 1 the gains are in units of the command per unit of the output.
"""

from typing import NamedTuple

from plant.laws.law import GainInfo, Span
from tuner.extensions.textbook_laws.pid_parts import (
    DERIVATIVE_GAIN,
    FILTER_TIME,
    PidConstants,
    filter_share,
    make_pid_law,
    row,
    tracking_share,
)


class Gains(NamedTuple):
    """kp [1/s2]; ki [1/s3]; kd [1/s]; t_f [s]; b, c, tracking and clamping [1]."""

    kp: float
    ki: float
    kd: float
    t_f: float
    b: float
    c: float
    tracking: float
    clamping: float


def prepare(gains: Gains, h: float) -> PidConstants:
    """Sample the filter and the tracking."""
    share, reset = filter_share(gains.t_f, h), tracking_share(gains.tracking, gains.kp, gains.ki, h)
    return PidConstants(gains.kp, gains.ki, gains.kd, share, gains.b, gains.c, reset, gains.clamping)


GAINS: tuple[GainInfo, ...] = (
    row(
        "kp", "s^-2", Span(60.0, 5.0, 400.0), Span(2.5, 0.2, 20.0), "proportional gain", scale="log", exclusive=True,
        integrals=0,
    ),
    row(
        "ki", "s^-3", Span(60.0, 0.1, 2000.0), Span(0.6, 0.01, 20.0), "integral gain", scale="log", integrals=1,
        term="integral term",
    ),
    DERIVATIVE_GAIN,
    FILTER_TIME,
)  # fmt: skip

LAW = make_pid_law("pid_parallel", "parallel", "PID", Gains, prepare, GAINS)
