"""Series (interacting) PID with set-point weights: a lead after a PI, as pneumatic controllers and many manuals have it.

    C(s) = K (1 + 1/(Ti s)) (1 + Td s)/(1 + Td/N s),    b and c on P and D,    rho and clamping on I, as in pid_parallel

Use it for gains of a controller whose manual calls its form series, interacting, classical or "rate before reset". SIMC prints
its rules for this form.

The law flies the parallel gains of the same transfer function: kp = K (1 + (Td - Tf)/Ti), ki = K/Ti, kd = K (Td - Tf)(1 - Tf/Ti),
with Tf = Td/N. The weights b and c act on the proportional and the derivative part of that parallel form.
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
    """Return the parallel gains of the same transfer function, sampled."""
    t_f, per_t_i = gains.t_d * inverse(gains.n), inverse(gains.t_i)
    lead = gains.t_d - t_f
    ki, kp, kd = gains.k * per_t_i, gains.k * (1.0 + lead * per_t_i), gains.k * lead * (1.0 - t_f * per_t_i)
    share, reset = filter_share(t_f, h), tracking_share(gains.tracking, kp, ki, h)
    return PidConstants(kp, ki, kd, share, gains.b, gains.c, reset, gains.clamping)


GAINS: tuple[GainInfo, ...] = (
    row(
        "k", "s^-2", Span(45.0, 5.0, 300.0), Span(1.5, 0.2, 15.0), "gain of the series form", symbol="K", scale="log",
        exclusive=True, integrals=0,
    ),
    row(
        "t_i", "s", Span(1.0, 0.05, 20.0), Span(4.0, 0.2, 60.0), "integral time, 0 for no integral", symbol="Ti",
        scale="log", term="integral term",
    ),
    row(
        "t_d", "s", Span(0.35, 0.02, 1.5), Span(2.0, 0.1, 8.0), "derivative time", symbol="Td", scale="log",
        term="derivative term",
    ),
    FILTER_RATIO,
)  # fmt: skip

LAW = make_pid_law("pid_series", "series (interacting)", "PI, then lead", Gains, prepare, GAINS)
