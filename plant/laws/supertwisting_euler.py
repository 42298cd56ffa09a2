"""Super-twisting control in explicit Euler steps: the usual implementation, kept to show its chatter.

    e = y - r,   S = e' + lambda e
    b0 u = r'' - lambda e' - k1 |S|^(1/2) sgn S + v,   v+ = v - h k2 sgn S

Use it for comparisons with published code alone: `supertwisting` has the same gains.

The law of `supertwisting`, sampled as most published code does it. It is locally unstable wherever |S| < (k1 h/2)^2 and never
comes to rest: even undisturbed it swings with |S| of order k1^2 h^2, and b0 u travels k2 per second and more. So it neither
follows a reference nor rejects a disturbance exactly; its integral is kept from winding up in the same way. If sensor noise
and rotor lag set the travel, nothing of the difference is left: with default gains on attitude, the rotors of the Hummingbird
travel 23 hover thrusts per second in moderate turbulence, and 27 with `supertwisting`, whose gain in its band is higher.
"""

from dataclasses import replace

from plant.laws import supertwisting
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.law import Nonlinearity
from plant.laws.supertwisting import Constants, Memory, differenced
from plant.laws.surface import surface
from plant.laws.twisting import Twist, undelivered
from plant.primitives import absolute, sign, sqrt


def root_term(s: float, constants: Constants) -> float:
    """k1 |S|^(1/2) sgn S [y/s2]."""
    return constants.twist.k1 * sqrt(absolute(s)) * sign(s)


def switching_term(s: float, constants: Constants) -> float:
    """k2 sgn S [y/s3]."""
    return constants.twist.k2 * sign(s)


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
    kept_back = undelivered(memory.twist.pull, channel.b0 * applied.excess)
    v = memory.twist.v + h * memory.twist.switching * kept_back
    root, switching = root_term(e.s, constants), switching_term(e.s, constants)
    demand = setpoint.acceleration - constants.lambda_ * e.error_rate - root + v
    return demand / channel.b0, Memory(Twist(v - h * switching, root, switching), measured.value)


LAW = replace(
    supertwisting.LAW,
    name="supertwisting_euler",
    title="super-twisting sliding mode control in explicit Euler steps",
    step=step,
    sampling="super-twisting term: explicit Euler",
    promises=frozenset(),
    nonlinear=(
        Nonlinearity("root term", root_term, "{y}/s"),
        Nonlinearity("switching term", switching_term, "{y}/s"),
    ),
)
