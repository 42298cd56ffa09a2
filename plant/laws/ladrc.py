"""Linear active disturbance rejection: linear ESO, PD on the estimates, disturbance estimate cancelled.

    b0 u = r'' + wc^2 (r - z1) + 2 zeta wc (r' - z2) - z3
    z1' = z2 + 3 wo (y - z1),   z2' = z3 + b0 u + 3 wo^2 (y - z1),   z3' = wo^3 (y - z1)

Use it where disturbances change faster than an integral follows, or where little but b0 is known of the plant, and sensors are
quiet enough for wo of 3 to 5 wc.

With the measured rate, y and its measured rate stand in for z1 and z2 and the observer only serves z3. Z. Gao, "Scaling and
bandwidth-parameterization based controller tuning", ACC 2003, pp. 4989-4996.

(omega_c, zeta) is the design by natural frequency and damping ratio, kp = wn^2 and kd = 2 zeta wn: the correct form of equation
(28) of Wu et al., Appl. Sci. 2025, 15(9), 5124, which gives the second gain alone (`ladrc_printed`). zeta = 1 is Gao's bandwidth
design. Expect 36 to 41 deg of phase margin at wo/wc = 3 to 5 even without any lag.
"""

from typing import NamedTuple

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.continuous import ContinuousForm, on_observer
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

SOURCE = "Gao, ACC 2003, pp. 4989-4996"
FAMILY = "linear ADRC in bandwidth form"


class Gains(NamedTuple):
    """omega_c [rad/s], zeta [1], omega_o [rad/s]."""

    omega_c: float
    zeta: float
    omega_o: float


class Constants(NamedTuple):
    """kp [1/s2], kd [1/s] and the observer's gains."""

    kp: float
    kd: float
    observer: ObserverConstants


def prepare(gains: Gains, h: float) -> Constants:
    """Bandwidth design: kp = wc^2, kd = 2 zeta wc."""
    wc = gains.omega_c
    return Constants(wc * wc, 2.0 * gains.zeta * wc, observer_constants(gains.omega_o, h))


def start(constants: Constants, measured: Measured, held: float) -> Observer:
    """Rest: the observer at the measurement, the disturbance what is held against."""
    return Observer(measured.value, measured.rate, 0.0 - held)


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
    from_observer = channel.rate_from_observer > 0.5
    value = select(from_observer, z.z1, measured.value)
    rate = select(from_observer, z.z2, measured.rate)
    demand = constants.kp * (setpoint.value - value) + constants.kd * (setpoint.rate - rate) + setpoint.acceleration
    return (demand - z.z3) / channel.b0, z


def continuous(gains: Gains, from_observer: bool) -> ContinuousForm:
    """Return the continuous form: PD on estimates or measurements, minus the disturbance estimate; states: z1 to z3."""
    kp, kd = gains.omega_c**2, 2.0 * gains.zeta * gains.omega_c
    if from_observer:
        feedback, direct = (-kp, -kd, -1.0), (kp, 0.0, 0.0, 0.0)
    else:
        feedback, direct = (0.0, 0.0, -1.0), (kp, -kp, -kd, 0.0)
    return on_observer(triple_pole(gains.omega_o), (feedback, (0.0,) * 3), (direct, (0.0,) * 4))


OMEGA_O = GainInfo(
    "omega_o",
    "wo",
    "rad/s",
    Span(10.0, 2.0, 75.0),
    Span(4.0, 0.5, 20.0),
    "log",
    SOURCE,
    "bandwidth of the extended state observer",
    exclusive=True,
    observer=True,
)

LAW = Law(
    name="ladrc",
    title="linear ADRC in bandwidth form",
    blocks=Blocks("PD, minus z3", measured="linear ESO", takes_command=True),
    source=SOURCE,
    Gains=Gains,
    Constants=Constants,
    Memory=Observer,
    prepare=prepare,
    start=start,
    step=step,
    gains=(
        GainInfo(
            "omega_c", "wc", "rad/s", Span(6.0, 1.0, 25.0), Span(1.2, 0.3, 6.0), "log", SOURCE,
            "bandwidth of the state feedback", exclusive=True,
        ),
        GainInfo(
            "zeta", "zeta", "1", Span(1.0, 0.4, 2.5), Span(1.0, 0.4, 2.5), "linear", SOURCE,
            "damping ratio of the state feedback; 1 in the source",
        ),
        OMEGA_O,
    ),
    sampling=f"{SAMPLING}; {FEEDBACK}",
    family=FAMILY,
    observer=triple_pole,
    continuous=continuous,
)  # fmt: skip
