"""Linear ADRC as printed: one error feedback gain, and no damping.

    b0 u = -z3 + ke (r - y),   ke = 2 zeta wn
    z1' = z2 + 3 wo (y - z1),   z2' = z3 + b0 u + 3 wo^2 (y - z1),   z3' = wo^3 (y - z1)

Use it to test the paper's claims alone.

Wu et al., Appl. Sci. 2025, 15(9), 5124, equations (26) and (28), where the gain is called ks and ke. A second-order channel
needs two: kp = wn^2 on the error and kd = 2 zeta wn on its rate (`ladrc`). With the disturbance cancelled, y'' = -ke (y - r)
is left, which swings at sqrt(ke) for ever; the hold and any lag of the actuators make the swing grow. It cannot hold a
vehicle: as attitude law of the Hummingbird, in 16 flights of 10 s in moderate turbulence, it turns over 0.9 to 1.6 s into each
with default gains, and none of 400 gains drawn from the ranges completes one; as position law it loses 7 of the 16.
"""

from typing import NamedTuple

from plant.laws import ladrc
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.ladrc import start
from plant.laws.law import Blocks, GainInfo, Law, Span
from plant.laws.observer import (
    FEEDBACK,
    SAMPLING,
    Observer,
    ObserverConstants,
    observe,
    observer_constants,
    triple_pole,
)
from plant.primitives import select

SOURCE = "Wu et al., Appl. Sci. 2025, 15(9), 5124"


class Gains(NamedTuple):
    """omega_n [rad/s], zeta [1], omega_o [rad/s]."""

    omega_n: float
    zeta: float
    omega_o: float


class Constants(NamedTuple):
    """ke [1/s2 where it acts, rad/s as printed] and the observer's gains."""

    ke: float
    observer: ObserverConstants


def prepare(gains: Gains, h: float) -> Constants:
    """Work out ke = 2 zeta wn."""
    return Constants(2.0 * gains.zeta * gains.omega_n, observer_constants(gains.omega_o, h))


def step(
    memory: Observer,
    constants: Constants,
    channel: Channel,
    setpoint: Setpoint,
    measured: Measured,
    applied: Applied,
    h: float,
) -> tuple[float, Observer]:
    """One control period."""
    z = observe(memory, constants.observer, measured.value, channel.b0 * applied.effect, h)
    value = select(channel.rate_from_observer > 0.5, z.z1, measured.value)
    return (constants.ke * (setpoint.value - value) - z.z3) / channel.b0, z


LAW = Law(
    name="ladrc_printed",
    title="linear ADRC as printed: error feedback without damping",
    blocks=Blocks("P, minus z3", measured="linear ESO", takes_command=True),
    source=SOURCE,
    Gains=Gains,
    Constants=Constants,
    Memory=Observer,
    prepare=prepare,
    start=start,
    step=step,
    gains=(
        GainInfo(
            "omega_n", "wn", "rad/s", Span(6.0, 1.0, 25.0), Span(1.2, 0.3, 6.0), "log", SOURCE,
            "natural frequency that the printed gain is worked out from; open in the source", exclusive=True,
        ),
        GainInfo(
            "zeta", "zeta", "1", Span(1.0, 0.4, 2.5), Span(1.0, 0.4, 2.5), "linear", SOURCE,
            "damping ratio that the printed gain is worked out from; open in the source",
        ),
        ladrc.OMEGA_O,
    ),
    sampling=f"{SAMPLING}; {FEEDBACK}",
    observer=triple_pole,
    promises=frozenset(),
)  # fmt: skip
