"""Parallel PID in acceleration units, derivative on the measurement, filtered, with back-calculation against windup.

    b0 u = r'' + kp (r - y) + I + kd (r' - yf'),    I' = ki (r - y) + (ki/kp) b0 (u_clipped - u),    Tf yf'' + yf' = y'

Use it first, and as the baseline of every comparison: few gains, disturbances that change slowly, and most export targets.

The straw man of the paper is kp = 2, kd = 5, ki = 0 (its table 2): a PD law whose 2 % settling time is about 9 s.
K. J. Astrom, T. Hagglund, Advanced PID Control, ISA 2006, chapters 3 and 13.
"""

from typing import NamedTuple

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.continuous import ContinuousForm
from plant.laws.law import Blocks, GainInfo, Law, Span
from plant.primitives import exp, maximum, select

SOURCE = "Astrom, Hagglund, Advanced PID Control, ISA 2006"
FAMILY = "PID with filtered derivative"
# A derivative filter faster than this [s] is left at it: no control period in use can tell it from none.
FASTEST_FILTER = 5e-4


class Gains(NamedTuple):
    """kp [1/s2], ki [1/s3], kd [1/s], t_f [s]."""

    kp: float
    ki: float
    kd: float
    t_f: float


class Constants(NamedTuple):
    """The gains with the derivative filter as a sampled pole and the reset rate ki/kp [1/s]."""

    kp: float
    ki: float
    kd: float
    smoothing: float
    reset: float


class Memory(NamedTuple):
    """integral [y/s2]; rate: filtered rate [y/s]; previous: last measured value [y]."""

    integral: float
    rate: float
    previous: float


def prepare(gains: Gains, h: float) -> Constants:
    """Sample the filter exactly; a zero filter time constant passes the rate through."""
    smoothing = 1.0 - exp(-h / maximum(gains.t_f, 1e-6))
    return Constants(gains.kp, gains.ki, gains.kd, smoothing, gains.ki / maximum(gains.kp, 1e-9))


def start(constants: Constants, measured: Measured, held: float) -> Memory:
    """Rest: the integral holds the plant, the filter at the measured rate."""
    return Memory(held, measured.rate, measured.value)


def step(
    memory: Memory,
    constants: Constants,
    channel: Channel,
    setpoint: Setpoint,
    measured: Measured,
    applied: Applied,
    h: float,
) -> tuple[float, Memory]:
    """One control period; the integral takes effect one period after it is formed."""
    error = setpoint.value - measured.value
    differenced = (measured.value - memory.previous) / h
    raw = select(channel.rate_from_observer > 0.5, differenced, measured.rate)
    rate = memory.rate + constants.smoothing * (raw - memory.rate)
    integral = memory.integral + h * constants.reset * channel.b0 * applied.excess
    demand = setpoint.acceleration + constants.kp * error + integral + constants.kd * (setpoint.rate - rate)
    return demand / channel.b0, Memory(integral + h * constants.ki * error, rate, measured.value)


def continuous(gains: Gains, from_observer: bool) -> ContinuousForm:  # noqa: ARG001
    """Return the continuous form; states: integral (none where ki = 0), filtered rate. Differencing y gives y' here."""
    per = 1.0 / max(gains.t_f, FASTEST_FILTER)
    a = ((0.0, 0.0), (0.0, -per))
    b = ((gains.ki, -gains.ki, 0.0, 0.0), (0.0, 0.0, per, 0.0))
    c = ((1.0, -gains.kd), (0.0, 0.0))
    d = ((gains.kp, -gains.kp, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0))
    states = slice(0 if gains.ki else 1, None)
    return ContinuousForm(tuple(row[states] for row in a[states]), b[states], tuple(row[states] for row in c), d)


LAW = Law(
    name="pid",
    title="PID, derivative on measurement, filtered, anti-windup",
    blocks=Blocks("PID", measured="low-pass of D"),
    source=SOURCE,
    Gains=Gains,
    Constants=Constants,
    Memory=Memory,
    prepare=prepare,
    start=start,
    step=step,
    gains=(
        GainInfo(
            "kp", "kp", "s^-2", Span(60.0, 5.0, 400.0), Span(2.5, 0.2, 20.0), "log", SOURCE,
            "proportional gain, acceleration per error", exclusive=True, integrals=0,
        ),
        GainInfo(
            "ki", "ki", "s^-3", Span(60.0, 0.1, 2000.0), Span(0.6, 0.01, 20.0), "log", SOURCE,
            "integral gain, acceleration per integrated error", integrals=1, term="integral term",
        ),
        GainInfo(
            "kd", "kd", "s^-1", Span(14.0, 2.0, 60.0), Span(2.6, 0.4, 15.0), "log", SOURCE,
            "derivative gain, acceleration per rate", integrals=-1, term="derivative term",
        ),
        GainInfo(
            "t_f", "Tf", "s", Span(0.005, 0.001, 0.05), Span(0.01, 0.002, 0.2), "log", SOURCE,
            "time constant of the derivative filter",
        ),
    ),
    sampling="filtered derivative: pole at exp(-h/Tf); integral: forward Euler, in force one period after it is formed",
    family=FAMILY,
    continuous=continuous,
)  # fmt: skip
