"""Shared parts of the forms of PID: weights, filtered derivative, anti-windup, gains.

    v = kp (b r - y) + I + D,    I' = ki (r - y),    Tf D' + D = kd (c r - y)'

v is in units of acceleration, b0 times the command. Every form turns its gains into these numbers in `prepare`. The set point is
differenced, so that a step in it gives the kick that a textbook's derivative of the error gives.

K. J. Astrom, T. Hagglund, Advanced PID Control, ISA 2006, sections 3.3 to 3.5 and 13.4.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.law import Blocks, GainInfo, Law, Span
from plant.primitives import maximum, minimum, select

SOURCE = "Astrom, Hagglund, Advanced PID Control, ISA 2006"
SAMPLING = (
    "integral: forward Euler, in force one period after it is formed; derivative: backward difference, its first-order filter "
    "by backward Euler"
)


class PidConstants(NamedTuple):
    """The numbers of every form.

    kp [1/s2]; ki [1/s3]; kd [1/s]; share [1] of a new difference that the filter takes over; b, c [1]; reset [1]: share of a lost
    command that a period takes out of the integral; clamping: 1 where the integral stops at a limit.
    """

    kp: float
    ki: float
    kd: float
    share: float
    b: float
    c: float
    reset: float
    clamping: float


class PidMemory(NamedTuple):
    """integral [y/s2]; rate: filtered rate of c r - y [y/s]; reference, value: the last ones [y]."""

    integral: float
    rate: float
    reference: float
    value: float


def filter_share(t_f: float, h: float) -> float:
    """Return the share of a new sample that a first-order filter takes.

    t_f: time constant [s]; 0 for the whole sample.
    """
    return h / (h + t_f)


def tracking_share(tracking: float, kp: float, ki: float, h: float) -> float:
    """Return the share of a lost command that back-calculation removes.

    It is that of a control period, and leaves the integral.

    tracking: tracking time over the integral time kp/ki; 0 for no back-calculation.
    """
    rate = ki / maximum(kp * tracking, 1e-12)
    return select(tracking > 0.0, minimum(h * rate, 1.0), 0.0)


def inverse(a: float) -> float:
    """Return 1/a, and 0 for 0."""
    return select(a > 0.0, 1.0 / maximum(a, 1e-12), 0.0)


def start(constants: Any, measured: Measured, held: float) -> PidMemory:
    """Rest at a set point equal to the measurement: the integral holds the plant, less what a weight b leaves."""
    offset = constants.kp * (constants.b - 1.0) * measured.value
    return PidMemory(held - offset, 0.0 - measured.rate, measured.value, measured.value)


def weighted_rate(
    filtered: float,
    reference: float,
    value: float,
    constants: Any,
    setpoint: Setpoint,
    measured: Measured,
    source: float,
    h: float,
) -> float:
    """Return the filtered rate of c r - y; source: 1 where y is differenced, 0 where a sensor measures its rate."""
    differenced = (measured.value - value) / h
    rate = select(source > 0.5, differenced, measured.rate)
    raw = constants.c * (setpoint.value - reference) / h - rate
    return filtered + constants.share * (raw - filtered)


def clamped(error: float, lost: float) -> float:
    """Return the error, without what would drive a limited command further; lost: after limits less before."""
    return select(lost < 0.0, minimum(error, 0.0), select(lost > 0.0, maximum(error, 0.0), error))


def step(
    memory: PidMemory,
    constants: Any,
    channel: Channel,
    setpoint: Setpoint,
    measured: Measured,
    applied: Applied,
    h: float,
) -> tuple[float, PidMemory]:
    """One control period; the integral takes effect one period after it is formed."""
    error, lost = setpoint.value - measured.value, channel.b0 * applied.excess
    rate = weighted_rate(
        memory.rate, memory.reference, memory.value, constants, setpoint, measured, channel.rate_from_observer, h
    )
    integral = memory.integral + constants.reset * lost
    demand = constants.kp * (constants.b * setpoint.value - measured.value) + integral + constants.kd * rate
    integrated = select(constants.clamping > 0.5, clamped(error, lost), error)
    after = PidMemory(integral + h * constants.ki * integrated, rate, setpoint.value, measured.value)
    return demand / channel.b0, after


def row(name: str, unit: str, attitude: Span, position: Span, meaning: str, **fields: Any) -> GainInfo:
    """Return a gain with its source; fields: others of `GainInfo`."""
    scale = fields.pop("scale", "linear")
    return GainInfo(name, fields.pop("symbol", name), unit, attitude, position, scale, SOURCE, meaning, **fields)


WEIGHT_OF_P = row(
    "b", "1", Span(1.0, 0.0, 1.0), Span(1.0, 0.0, 1.0), "set-point weight of the proportional part", optional=True
)
WEIGHTS = (
    WEIGHT_OF_P,
    row(
        "c", "1", Span(0.0, 0.0, 1.0), Span(0.0, 0.0, 1.0),
        "set-point weight of the derivative part: 0 for D on the measurement, 1 for D on the error", optional=True,
    ),
)  # fmt: skip
TRACKING = row(
    "tracking", "1", Span(1.0, 0.1, 10.0), Span(1.0, 0.1, 10.0),
    "tracking time over the integral time, 0 for no back-calculation", symbol="rho", scale="log",
    term="back-calculation", optional=True,
)  # fmt: skip
ANTI_WINDUP = (
    TRACKING,
    row(
        "clamping", "1", Span(0.0, 0.0, 1.0), Span(0.0, 0.0, 1.0),
        "1: the integral stops while a limit holds the command and the error drives it further; 0: it does not", optional=True,
    ),
)  # fmt: skip
FILTER_RATIO = row(
    "n", "1", Span(10.0, 2.0, 30.0), Span(10.0, 2.0, 30.0),
    "derivative time over the time constant of its filter, 0 for no filter", symbol="N", optional=True,
)  # fmt: skip
DERIVATIVE_GAIN = row(
    "kd", "s^-1", Span(14.0, 2.0, 60.0), Span(2.6, 0.4, 15.0), "derivative gain", scale="log", integrals=-1,
    term="derivative term",
)  # fmt: skip
FILTER_TIME = row(
    "t_f", "s", Span(0.01, 0.0, 0.05), Span(0.05, 0.0, 0.4),
    "time constant of the derivative filter, 0 for none", symbol="Tf",
)  # fmt: skip


def make_pid_law(
    name: str,
    title: str,
    part: str,
    Gains: Any,
    prepare: Callable[[Any, float], PidConstants],
    gains: tuple[GainInfo, ...],
) -> Law:
    """Return the law of one form of PID.

    Args:
        name: Name of the law.
        title: Form in words.
        part: Label of its block in drawings.
        Gains: Record of its gains.
        prepare: Turns gains into the numbers of every form.
        gains: Description of each gain; weights and anti-windup follow.
    """
    return Law(
        name=name,
        title=f"{title} PID with set-point weights",
        blocks=Blocks(part, reference="weights b, c", measured="low-pass of D"),
        source=SOURCE,
        Gains=Gains,
        Constants=PidConstants,
        Memory=PidMemory,
        prepare=prepare,
        start=start,
        step=step,
        gains=(*gains, *WEIGHTS, *ANTI_WINDUP),
        sampling=SAMPLING,
        promises=frozenset({"rejects"}),
    )
