"""First-order linear ADRC in bandwidth form.

    b0 u = wc (r - z1) - z2,    z1' = z2 + b0 u + 2 wo (y - z1),    z2' = wo^2 (y - z1)

It is for channels that answer like y' = f + b0 u.

Use it for levels, temperatures, speeds, pressures and currents: plants whose command changes the rate of the output. For
K/(T s + 1) without dead time the channel's b0 is K/T; with dead time begin with 1.5 to 3 times K/T. Begin with
wc = 4/(settling time) and wo = 3 to 10 wc, at most 0.3/(control period).

b0 of this law is a rate per unit of command, not an acceleration. It does not hold a plant y'' = f + b0 u: take `ladrc` there.
"""

from typing import NamedTuple

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.law import Blocks, GainInfo, Law, Span
from plant.primitives import exp

SOURCE = "G. Herbst, A Simulative Study on Active Disturbance Rejection Control, Electronics 2013, 2(3), 246-279"


class Gains(NamedTuple):
    """omega_c, omega_o [rad/s]."""

    omega_c: float
    omega_o: float


class Constants(NamedTuple):
    """kp [1/s], and the gains of the current observer: l1 [1], l2 [1/s]."""

    kp: float
    l1: float
    l2: float


class Memory(NamedTuple):
    """z1: estimate of y [y]; z2: estimate of f [y/s]."""

    z1: float
    z2: float


def prepare(gains: Gains, h: float) -> Constants:
    """Place both poles of the sampled observer at exp(-wo h)."""
    pole = exp(-gains.omega_o * h)
    return Constants(gains.omega_c, 1.0 - pole * pole, (1.0 - pole) * (1.0 - pole) / h)


def start(constants: Constants, measured: Measured, held: float) -> Memory:  # noqa: ARG001
    """Rest: the estimate at the measurement, the disturbance what is held against."""
    return Memory(measured.value, 0.0 - held)


def step(
    memory: Memory,
    constants: Constants,
    channel: Channel,
    setpoint: Setpoint,
    measured: Measured,
    applied: Applied,
    h: float,
) -> tuple[float, Memory]:
    """One control period: predict with what was delivered, correct with the measurement, decide."""
    predicted = memory.z1 + h * (memory.z2 + channel.b0 * applied.effect)
    innovation = measured.value - predicted
    z1, z2 = predicted + constants.l1 * innovation, memory.z2 + constants.l2 * innovation
    return (constants.kp * (setpoint.value - z1) - z2) / channel.b0, Memory(z1, z2)


GAINS: tuple[GainInfo, ...] = (
    GainInfo(
        "omega_c", "wc", "rad/s", Span(6.0, 1.0, 25.0), Span(1.2, 0.3, 6.0), "log", SOURCE,
        "bandwidth of the feedback, about 4 over the settling time", exclusive=True,
    ),
    GainInfo(
        "omega_o", "wo", "rad/s", Span(30.0, 2.0, 150.0), Span(6.0, 0.5, 40.0), "log", SOURCE,
        "bandwidth of the extended state observer", exclusive=True, observer=True,
    ),
)  # fmt: skip

LAW = Law(
    name="adrc1",
    title="first-order linear ADRC in bandwidth form",
    blocks=Blocks("P, minus z2", measured="linear ESO", takes_command=True),
    source=SOURCE,
    Gains=Gains,
    Constants=Constants,
    Memory=Memory,
    prepare=prepare,
    start=start,
    step=step,
    gains=GAINS,
    sampling="observer: current estimator of the plant with its input held, both poles at exp(-wo h)",
    promises=frozenset(),
)
