"""ADRC with a generalised super-twisting term: its linear parts also meet what of the disturbance grows with S.

    e = y - r,   S = e' + lambda e
    b0 u = -z3 + r'' - lambda e' - k1 phi1(S) + v,   v' = -k2 phi2(S)
    phi1 = |S|^(1/2) sgn S + mu S,   phi2 = sgn S + 3 mu |S|^(1/2) sgn S + 2 mu^2 S
    z1' = z2 + 3 wo (y - z1),   z2' = z3 + b0 u + 3 wo^2 (y - z1),   z3' = wo^3 (y - z1)

Use it where the disturbance grows with the error too, as drag and a wrong b0 make it.

J. A. Moreno, CCE 2009, on the surface and the observer of `hybrid`; k2 here is half of Moreno's, so that mu = 0 is
`hybrid_true_sta` with the same gains. This is where the printed law's k2 S has its place: mu k1 S, in addition to the integral
and not in place of it. Sampled without chatter and kept from winding up as in `twisting`.
"""

from typing import NamedTuple

from plant.laws import hybrid, observer, supertwisting, twisting
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.ladrc import OMEGA_O
from plant.laws.law import Blocks, GainInfo, Law, Span, SuperTwisting
from plant.laws.observer import Observer, ObserverConstants, observe, observer_constants, triple_pole
from plant.laws.surface import surface
from plant.laws.twisting import NONLINEAR, Twist, TwistConstants, super_twisting, twist_constants

SOURCE = "Moreno, CCE 2009"


class Gains(NamedTuple):
    """omega_o [rad/s], lambda_ [1/s], k1 [y^(1/2) s^(-3/2)], k2 [y/s3], mu [(s/y)^(1/2)]."""

    omega_o: float
    lambda_: float
    k1: float
    k2: float
    mu: float


class Constants(NamedTuple):
    """Observer, slope of the surface [1/s] and the super-twisting term, sampled."""

    observer: ObserverConstants
    lambda_: float
    twist: TwistConstants


class Memory(NamedTuple):
    """State of the observer and of the super-twisting term."""

    observer: Observer
    twist: Twist


def prepare(gains: Gains, h: float) -> Constants:
    """Sample the observer and the super-twisting term."""
    term = twist_constants(gains.k1, gains.k2, gains.mu, h)
    return Constants(observer_constants(gains.omega_o, h), gains.lambda_, term)


def start(constants: Constants, measured: Measured, held: float) -> Memory:
    """Rest: the observer at the measurement, the disturbance what is held against, nothing integrated."""
    return Memory(Observer(measured.value, measured.rate, 0.0 - held), Twist(0.0, 0.0, 0.0))


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
    z = observe(memory.observer, constants.observer, measured.value, channel.b0 * applied.effect, h)
    e = surface(constants.lambda_, channel, setpoint, measured, z.z2)
    w, twisted = super_twisting(memory.twist, e.s, channel.b0 * applied.excess, constants)
    demand = setpoint.acceleration - constants.lambda_ * e.error_rate + w
    return (demand - z.z3) / channel.b0, Memory(z, twisted)


LAMBDA = hybrid.LAW.gains[1]
MU = GainInfo(
    "mu",
    "mu",
    "{y}^(-1/2) s^(1/2)",
    Span(0.5, 0.0, 5.0),
    Span(0.5, 0.0, 5.0),
    "linear",
    SOURCE,
    "share of the linear parts; 0 is the super-twisting term",
    term="linear part",
)

LAW = Law(
    name="hybrid_gsta",
    title="ADRC with a generalised super-twisting term",
    blocks=Blocks("surface S, generalized super-twisting, minus z3", measured="linear ESO", takes_command=True),
    source=SOURCE,
    Gains=Gains,
    Constants=Constants,
    Memory=Memory,
    prepare=prepare,
    start=start,
    step=step,
    gains=(OMEGA_O, LAMBDA, supertwisting.K1, supertwisting.K2, MU),
    sampling=f"{observer.SAMPLING}; {twisting.SAMPLING}",
    nonlinear=NONLINEAR,
    observer=triple_pole,
    super_twisting=SuperTwisting("k1", "k2", "mu"),
)
