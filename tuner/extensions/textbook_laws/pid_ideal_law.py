"""Ideal PID (ISA standard form) with set-point weights: one gain K over all three parts, and times.

    b0 u = K (b r - y + I + D),    Td/N D' + D = Td (c r - y)'
    I' = (r - y)/Ti + b0 (u_clipped - u)/(K rho Ti),    clamping = 1: without (r - y)/Ti where it drives a limited u on

Use it for gains that a manual prints as gain, reset time and rate time, and for design rules (SIMC, AMIGO, Ziegler-Nichols). A
manual that prints a proportional band PB in per cent has K = 100/PB; one that prints repeats per minute has Ti = 60/repeats.

Ti = 0 switches the integral off, Td = 0 the derivative.
"""

from typing import NamedTuple

from plant.laws.law import GainInfo, Span
from tuner.extensions.textbook_laws.pid_parts import (
    FILTER_RATIO,
    PidConstants,
    filter_share,
    inverse,
    make_pid_law,
    row,
    tracking_share,
)


class Gains(NamedTuple):
    """k [1/s2], t_i, t_d [s], n, b, c [1], tracking, clamping [1]."""

    k: float
    t_i: float
    t_d: float
    n: float
    b: float
    c: float
    tracking: float
    clamping: float


def prepare(gains: Gains, h: float) -> PidConstants:
    """Return the parallel gains of the same law, sampled."""
    ki, kd = gains.k * inverse(gains.t_i), gains.k * gains.t_d
    share, reset = filter_share(gains.t_d * inverse(gains.n), h), tracking_share(gains.tracking, gains.k, ki, h)
    return PidConstants(gains.k, ki, kd, share, gains.b, gains.c, reset, gains.clamping)


GAINS: tuple[GainInfo, ...] = (
    row(
        "k", "s^-2", Span(60.0, 5.0, 400.0), Span(2.5, 0.2, 20.0), "gain of all three parts", symbol="K", scale="log",
        exclusive=True, integrals=0,
    ),
    row(
        "t_i", "s", Span(1.0, 0.05, 20.0), Span(4.0, 0.2, 60.0), "integral time, 0 for no integral", symbol="Ti",
        scale="log", term="integral term",
    ),
    row(
        "t_d", "s", Span(0.23, 0.02, 1.0), Span(1.0, 0.1, 5.0), "derivative time", symbol="Td", scale="log",
        term="derivative term",
    ),
    FILTER_RATIO,
)  # fmt: skip

LAW = make_pid_law("pid_ideal", "ideal (ISA)", "PID", Gains, prepare, GAINS)
