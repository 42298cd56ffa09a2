"""Super-twisting control on a sliding surface, without any observer.

    e = y - r,   S = e' + lambda e
    b0 u = r'' - lambda e' - k1 |S|^(1/2) sgn S + v,   v' = -k2 sgn S

Use it where the fastest change of the disturbance is known and actuators are fast: it needs no observer, and rejects the
disturbance in finite time.

A. Levant, "Sliding order and sliding accuracy in sliding mode control", Int. J. Control 58(6), 1993: S and S' reach 0 in
finite time and stay there under every disturbance whose derivative is at most L, if k2 > L and k1^2 > k2 + L (R. Seeber,
M. Horn, Automatica 84, 2017). Sampled without chatter and kept from winding up as in `twisting`; an actuator of lag tau leaves a
limit cycle of amplitude 1.31 (tau k2/k1)^2 in S at the frequency k1/(tau k2^(1/2)).

If the channel takes no measured rate, y is differenced, and the half period by which that is late is made up for with the
acceleration delivered and -v, the law's own estimate of the disturbance; without that the term would chatter.
"""

from typing import NamedTuple

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.law import Blocks, GainInfo, Law, Span, SuperTwisting
from plant.laws.surface import surface
from plant.laws.twisting import NONLINEAR, SAMPLING, Twist, TwistConstants, super_twisting, twist_constants

SOURCE = "Levant, Int. J. Control 58(6), 1993"


class Gains(NamedTuple):
    """lambda_ [1/s], k1 [y^(1/2) s^(-3/2)], k2 [y/s3]."""

    lambda_: float
    k1: float
    k2: float


class Constants(NamedTuple):
    """Slope of the surface [1/s] and the sampled super-twisting term."""

    lambda_: float
    twist: TwistConstants


class Memory(NamedTuple):
    """State of the super-twisting term; previous: last measured value [y]."""

    twist: Twist
    previous: float


def prepare(gains: Gains, h: float) -> Constants:
    """Sample the super-twisting term."""
    return Constants(gains.lambda_, twist_constants(gains.k1, gains.k2, 0.0, h))


def start(constants: Constants, measured: Measured, held: float) -> Memory:
    """Rest: the integral holds the plant; the last value is the one that the measured rate leads from."""
    return Memory(Twist(held, 0.0, 0.0), measured.value - constants.twist.h * measured.rate)


def differenced(memory: Memory, channel: Channel, measured: Measured, applied: Applied, h: float) -> float:
    """Rate of y [y/s] now: the mean of the last period, advanced by half of it."""
    acceleration = channel.b0 * applied.effect - memory.twist.v
    return (measured.value - memory.previous) / h + 0.5 * h * acceleration


def step(
    memory: Memory,
    constants: Constants,
    channel: Channel,
    setpoint: Setpoint,
    measured: Measured,
    applied: Applied,
    h: float,
) -> tuple[float, Memory]:
    """One control period."""
    e = surface(constants.lambda_, channel, setpoint, measured, differenced(memory, channel, measured, applied, h))
    w, twisted = super_twisting(memory.twist, e.s, channel.b0 * applied.excess, constants)
    demand = setpoint.acceleration - constants.lambda_ * e.error_rate + w
    return demand / channel.b0, Memory(twisted, measured.value)


LAMBDA = GainInfo(
    "lambda_",
    "lambda",
    "s^-1",
    Span(5.0, 0.5, 20.0),
    Span(1.0, 0.2, 5.0),
    "log",
    SOURCE,
    "slope of the sliding surface",
    exclusive=True,
)
K1 = GainInfo(
    "k1",
    "k1",
    "{y}^(1/2) s^(-3/2)",
    Span(12.0, 1.0, 60.0),
    Span(2.0, 0.2, 12.0),
    "log",
    SOURCE,
    "gain of the square root of the sliding variable",
    exclusive=True,
)
K2 = GainInfo(
    "k2",
    "k2",
    "{y} s^-3",
    Span(80.0, 1.0, 1000.0),
    Span(1.0, 0.05, 20.0),
    "log",
    SOURCE,
    "slope of the switched integral; exceeds the fastest change of the disturbance",
    term="switched integral",
)

LAW = Law(
    name="supertwisting",
    title="super-twisting sliding mode control, sampled without chatter",
    blocks=Blocks("surface S, super-twisting"),
    source=SOURCE,
    Gains=Gains,
    Constants=Constants,
    Memory=Memory,
    prepare=prepare,
    start=start,
    step=step,
    gains=(LAMBDA, K1, K2),
    sampling=SAMPLING,
    nonlinear=NONLINEAR,
    super_twisting=SuperTwisting("k1", "k2"),
)
