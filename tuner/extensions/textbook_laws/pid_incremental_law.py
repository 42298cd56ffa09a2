"""Incremental (velocity) PID: each period adds an increment to the command that the actuator took.

    b0 u(k) = b0 u_clipped(k-1) + kp (b dr - dy) + ki h (r - y) + (D(k) - D(k-1)),    Tf D' + D = kd (c r - y)'

Use it as programmable controllers have it: it needs no anti-windup, because it adds to the limited command. b = 0 and c = 0 give
the form whose proportional and derivative parts see the measurement alone.

ki must be above 0: without an integral nothing ties the command to the error, and it drifts.
"""

from typing import NamedTuple

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.law import Blocks, GainInfo, Law, Span
from tuner.extensions.textbook_laws.pid_parts import (
    DERIVATIVE_GAIN,
    FILTER_TIME,
    SOURCE,
    WEIGHTS,
    filter_share,
    row,
    weighted_rate,
)


class Gains(NamedTuple):
    """kp [1/s2], ki [1/s3], kd [1/s], t_f [s], b, c [1]."""

    kp: float
    ki: float
    kd: float
    t_f: float
    b: float
    c: float


class Constants(NamedTuple):
    """The gains, with the share [1] of the derivative filter."""

    kp: float
    ki: float
    kd: float
    share: float
    b: float
    c: float


class Memory(NamedTuple):
    """demand [y/s2]: last b0 u before limits; rate [y/s]: filtered; reference, value [y]."""

    demand: float
    rate: float
    reference: float
    value: float


def prepare(gains: Gains, h: float) -> Constants:
    """Sample the filter."""
    return Constants(gains.kp, gains.ki, gains.kd, filter_share(gains.t_f, h), gains.b, gains.c)


def start(constants: Constants, measured: Measured, held: float) -> Memory:  # noqa: ARG001
    """Rest at the measurement, with the command that holds the plant."""
    return Memory(held, 0.0, measured.value, measured.value)


def step(
    memory: Memory,
    constants: Constants,
    channel: Channel,
    setpoint: Setpoint,
    measured: Measured,
    applied: Applied,
    h: float,
) -> tuple[float, Memory]:
    """One control period; the integral takes effect at once."""
    rate = weighted_rate(
        memory.rate, memory.reference, memory.value, constants, setpoint, measured, channel.rate_from_observer, h
    )
    proportional = constants.b * (setpoint.value - memory.reference) - (measured.value - memory.value)
    integral = h * constants.ki * (setpoint.value - measured.value)
    increment = constants.kp * proportional + integral + constants.kd * (rate - memory.rate)
    demand = memory.demand + channel.b0 * applied.excess + increment
    return demand / channel.b0, Memory(demand, rate, setpoint.value, measured.value)


GAINS: tuple[GainInfo, ...] = (
    row(
        "kp", "s^-2", Span(60.0, 5.0, 400.0), Span(2.5, 0.2, 20.0), "proportional gain", scale="log", integrals=0,
        term="proportional term",
    ),
    row(
        "ki", "s^-3", Span(60.0, 0.1, 2000.0), Span(0.6, 0.01, 20.0), "integral gain", scale="log", exclusive=True,
        integrals=1,
    ),
    DERIVATIVE_GAIN,
    FILTER_TIME,
    *WEIGHTS,
)  # fmt: skip

LAW = Law(
    name="pid_incremental",
    title="incremental (velocity) PID with set-point weights",
    blocks=Blocks("increments, summed", reference="weights b, c", measured="low-pass of D"),
    source=SOURCE,
    Gains=Gains,
    Constants=Constants,
    Memory=Memory,
    prepare=prepare,
    start=start,
    step=step,
    gains=GAINS,
    sampling="integral: backward Euler; derivative: backward difference, its first-order filter by backward Euler",
    promises=frozenset({"rejects"}),
)
