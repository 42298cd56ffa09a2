"""Reference model with feed-forward, and PID on the difference to it.

    ym'' = wm^2 (r - ym) - 2 zm wm ym',    b0 u = a2 ym'' + a1 ym' + a0 ym + kp (ym - y) + I + kd (ym' - yf'),    I' = ki (ym - y)
    Tf yf'' + yf' = y'

Use it where a set point must be followed in a prescribed way and feedback is for disturbances alone: with the plant
b0/(a2 s^2 + a1 s + a0) known, the answer to a step is that of the model, whatever kp, ki and kd are. Write a2 = 0 for a plant of
first order, b0/(a1 s + a0), and a2 = a1 = a0 = 0 for a reference model without feed-forward.

Anti-windup is back-calculation with the tracking time kp/ki.
"""

from typing import NamedTuple

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.law import Blocks, GainInfo, Law, Span
from plant.primitives import select
from tuner.extensions.textbook_laws.pid_parts import (
    DERIVATIVE_GAIN,
    FILTER_TIME,
    SOURCE,
    filter_share,
    row,
    tracking_share,
)


class Gains(NamedTuple):
    """Gains of model, plant's inverse and PID.

    omega_m [rad/s]; zeta_m, a2 [1]; a1, kd [1/s]; a0, kp [1/s2]; ki [1/s3]; t_f [s].
    """

    omega_m: float
    zeta_m: float
    a2: float
    a1: float
    a0: float
    kp: float
    ki: float
    kd: float
    t_f: float


class Constants(NamedTuple):
    """Numbers of the model, the plant's inverse and the PID.

    stiffness [1/s2], damping [1/s]: of the model; share, reset [1]: of the filter and of back-calculation in a period.
    """

    stiffness: float
    damping: float
    a2: float
    a1: float
    a0: float
    kp: float
    ki: float
    kd: float
    share: float
    reset: float


class Memory(NamedTuple):
    """State of the model [y, y/s], integral [y/s2], filtered rate [y/s], last y."""

    model: float
    speed: float
    integral: float
    rate: float
    value: float


def prepare(gains: Gains, h: float) -> Constants:
    """Sample the filter and the tracking."""
    wm = gains.omega_m
    share, reset = filter_share(gains.t_f, h), tracking_share(1.0, gains.kp, gains.ki, h)
    inverse = (gains.a2, gains.a1, gains.a0)
    return Constants(wm * wm, 2.0 * gains.zeta_m * wm, *inverse, gains.kp, gains.ki, gains.kd, share, reset)


def start(constants: Constants, measured: Measured, held: float) -> Memory:
    """Rest: the model at the measurement, the integral at what holds the plant beyond the feed-forward."""
    integral = held - constants.a0 * measured.value
    return Memory(measured.value, measured.rate, integral, measured.rate, measured.value)


def step(
    memory: Memory,
    constants: Constants,
    channel: Channel,
    setpoint: Setpoint,
    measured: Measured,
    applied: Applied,
    h: float,
) -> tuple[float, Memory]:
    """One control period; model and integral take effect one period after they are formed."""
    acceleration = constants.stiffness * (setpoint.value - memory.model) - constants.damping * memory.speed
    forward = constants.a2 * acceleration + constants.a1 * memory.speed + constants.a0 * memory.model
    differenced = (measured.value - memory.value) / h
    raw = select(channel.rate_from_observer > 0.5, differenced, measured.rate)
    rate = memory.rate + constants.share * (raw - memory.rate)
    error = memory.model - measured.value
    integral = memory.integral + constants.reset * channel.b0 * applied.excess
    demand = forward + constants.kp * error + integral + constants.kd * (memory.speed - rate)
    speed = memory.speed + h * acceleration
    after = Memory(memory.model + h * speed, speed, integral + h * constants.ki * error, rate, measured.value)
    return demand / channel.b0, after


GAINS: tuple[GainInfo, ...] = (
    row(
        "omega_m", "rad/s", Span(6.0, 1.0, 25.0), Span(1.2, 0.3, 6.0), "natural frequency of the reference model",
        symbol="wm", scale="log", exclusive=True, observer=True,
    ),
    row(
        "zeta_m", "1", Span(1.0, 0.4, 2.5), Span(1.0, 0.4, 2.5), "damping ratio of the reference model", symbol="zm",
        optional=True,
    ),
    row(
        "a2", "1", Span(1.0, 0.0, 2.0), Span(1.0, 0.0, 2.0), "the plant's inverse: command over acceleration",
        term="feed-forward of acceleration",
    ),
    row(
        "a1", "s^-1", Span(0.0, 0.0, 5.0), Span(0.0, 0.0, 2.0), "the plant's inverse: command over rate",
        term="feed-forward of rate",
    ),
    row(
        "a0", "s^-2", Span(0.0, 0.0, 20.0), Span(0.0, 0.0, 2.0), "the plant's inverse: command over value",
        term="feed-forward of value",
    ),
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

LAW = Law(
    name="model_following",
    title="PID behind a reference model with feed-forward",
    blocks=Blocks("PID and inverse plant", reference="reference model", measured="low-pass of D"),
    source=SOURCE,
    Gains=Gains,
    Constants=Constants,
    Memory=Memory,
    prepare=prepare,
    start=start,
    step=step,
    gains=GAINS,
    sampling="model: symplectic Euler; integral: forward Euler, in force one period after it is formed; derivative: backward "
    "difference, its first-order filter by backward Euler",
    promises=frozenset({"rejects"}),
)
