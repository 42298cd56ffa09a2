"""Smith predictor: PI on what the plant would show without its dead time.

    b0 u = K (b r - p) + I,    I' = (K/Ti)(r - p) + b0 (u_clipped - u)/(rho Ti)
    p = y + ym(t) - ym(t - L),    Tm ym' + ym = Km b0 u

Use it where the dead time is longer than the time constant and known to 20 %: PI alone must be slow there. The model
Km/(Tm s + 1) with dead time L is of the whole way from command to measurement, delays of the actuator included.

L is rounded to whole control periods, of which there are at most 64: step the channel at every n-th period for a longer one.
The plant must be stable. It is for plants without an integral, and does not hold y'' = f + b0 u.

O. J. M. Smith, Closer control of loops with dead time, Chem. Eng. Progress 53 (1957); Astrom, Hagglund, section 8.6.
"""

from typing import NamedTuple

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.law import Blocks, GainInfo, Law, Span
from plant.primitives import exp, floor, select
from tuner.extensions.textbook_laws.delay_line import Line, filled, first, pushed
from tuner.extensions.textbook_laws.pid_parts import TRACKING, WEIGHT_OF_P, inverse, row, tracking_share


class Gains(NamedTuple):
    """k [1/s2], t_i [s], k_m [s2], t_m, l_m [s], b, tracking [1]."""

    k: float
    t_i: float
    k_m: float
    t_m: float
    l_m: float
    b: float
    tracking: float


class Constants(NamedTuple):
    """kp, ki, b, reset of the PI; pole and gain of the sampled model, its dead time in control periods."""

    kp: float
    ki: float
    b: float
    reset: float
    pole: float
    gain: float
    periods: float


class Memory(NamedTuple):
    """integral, demand [y/s2]: demand is the last b0 u before limits; model, line [y]: ym and its past."""

    integral: float
    demand: float
    model: float
    line: Line


def prepare(gains: Gains, h: float) -> Constants:
    """Sample the model with its input held."""
    ki, pole = gains.k * inverse(gains.t_i), exp(-h * inverse(gains.t_m))
    reset = tracking_share(gains.tracking, gains.k, ki, h)
    pole = select(gains.t_m > 0.0, pole, 0.0)
    return Constants(gains.k, ki, gains.b, reset, pole, gains.k_m, floor(gains.l_m / h + 0.5))


def start(constants: Constants, measured: Measured, held: float) -> Memory:
    """Rest at a set point equal to the measurement: the model shows what it settles to."""
    model = constants.gain * held
    return Memory(held - constants.kp * (constants.b - 1.0) * measured.value, held, model, filled(model))


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
    lost = channel.b0 * applied.excess
    model = constants.pole * memory.model + (1.0 - constants.pole) * constants.gain * (memory.demand + lost)
    delayed = select(constants.periods > 0.5, first(memory.line), model)
    predicted = measured.value + (model - delayed)
    integral = memory.integral + constants.reset * lost
    demand = constants.kp * (constants.b * setpoint.value - predicted) + integral
    after = integral + h * constants.ki * (setpoint.value - predicted)
    return demand / channel.b0, Memory(after, demand, model, pushed(memory.line, model, constants.periods))


GAINS: tuple[GainInfo, ...] = (
    row(
        "k", "s^-2", Span(60.0, 5.0, 400.0), Span(2.5, 0.2, 20.0), "gain of the PI", symbol="K", scale="log",
        exclusive=True, integrals=0,
    ),
    row(
        "t_i", "s", Span(1.0, 0.05, 20.0), Span(4.0, 0.2, 60.0), "integral time, 0 for no integral", symbol="Ti",
        scale="log", term="integral term",
    ),
    row(
        "k_m", "s^2", Span(0.01, 0.001, 0.1), Span(0.1, 0.01, 1.0), "gain of the model", symbol="Km", scale="log",
        term="predictor",
    ),
    row(
        "t_m", "s", Span(0.2, 0.02, 2.0), Span(1.0, 0.1, 10.0), "time constant of the model", symbol="Tm", scale="log",
    ),
    row(
        "l_m", "s", Span(0.02, 0.0, 0.2), Span(0.1, 0.0, 0.25),
        "dead time of the model, rounded to whole control periods, of which 64 are the most", symbol="L",
    ),
    WEIGHT_OF_P,
    TRACKING,
)  # fmt: skip

LAW = Law(
    name="smith",
    title="Smith predictor: PI with a model of first order and dead time",
    blocks=Blocks("PI", reference="weight b", measured="predictor", takes_command=True),
    source="O. J. M. Smith, Chem. Eng. Progress 53 (1957) 217-219",
    Gains=Gains,
    Constants=Constants,
    Memory=Memory,
    prepare=prepare,
    start=start,
    step=step,
    gains=GAINS,
    sampling="integral: forward Euler, in force one period after it is formed; model: exact with its input held; dead time "
    "rounded to whole control periods",
    promises=frozenset(),
)
