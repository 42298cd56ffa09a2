"""Lead or lag compensator with an integral and a notch.

    C(s) = K (1 + 1/(Ti s)) (1 + s/z)/(1 + s/p) N(s),    N(s) = (s^2 + wn^2)/(s^2 + dw s + wn^2)
    wn = 2 pi fn,    dw = 2 pi df,    error r - y

Use it for a design from a Bode diagram: p above z is a lead, p below z a lag, and the notch takes out a resonance. Ti = 0 leaves
out the integral, a notch of 0 the notch.

Anti-windup is back-calculation with the tracking time Ti.
"""

from typing import NamedTuple

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.filters import Delays, Section, notch, step_section
from plant.laws.law import Blocks, GainInfo, Law, Span
from tuner.extensions.textbook_laws.pid_parts import inverse, row, tracking_share


class Gains(NamedTuple):
    """k [1/s2], t_i [s], zero, pole [rad/s], notch, notch_width [Hz]."""

    k: float
    t_i: float
    zero: float
    pole: float
    notch: float
    notch_width: float


class Constants(NamedTuple):
    """Sampled lead: direct, pole [1], after [1]; notch; ki [1/s]: integral of the compensated error; reset, k."""

    direct: float
    pole: float
    after: float
    notch: Section
    ki: float
    reset: float
    k: float


class Memory(NamedTuple):
    """lead [y]: state of the lead; notch: of the notch; integral [y/s2]."""

    lead: float
    notch: Delays
    integral: float


def prepare(gains: Gains, h: float) -> Constants:
    """Sample lead and notch by the bilinear transform; that of the notch is exact at its centre and width."""
    zero, pole = 0.5 * h * gains.zero, 0.5 * h * gains.pole
    ratio, scale = gains.pole / gains.zero, 1.0 / (1.0 + pole)
    direct, sampled = ratio * (1.0 + zero) * scale, (1.0 - pole) * scale
    ki = inverse(gains.t_i)
    after = ratio * (zero - 1.0) * scale + sampled * direct
    section = notch(gains.notch, gains.notch_width, h)
    return Constants(direct, sampled, after, section, ki, tracking_share(1.0, 1.0, ki, h), gains.k)


def start(constants: Constants, measured: Measured, held: float) -> Memory:  # noqa: ARG001
    """Rest without an error: the integral holds the plant."""
    return Memory(0.0, Delays(0.0, 0.0), held)


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
    lead = constants.direct * error + memory.lead
    filtered, section = step_section(memory.notch, lead, constants.notch)
    proportional = constants.k * filtered
    integral = memory.integral + constants.reset * channel.b0 * applied.excess
    after = Memory(
        constants.after * error + constants.pole * memory.lead,
        section,
        integral + h * constants.ki * proportional,
    )
    return (proportional + integral) / channel.b0, after


SOURCE = "G. F. Franklin, J. D. Powell, A. Emami-Naeini, Feedback Control of Dynamic Systems, sections 6.7 and 8.3"
GAINS: tuple[GainInfo, ...] = (
    row(
        "k", "s^-2", Span(45.0, 5.0, 300.0), Span(1.0, 0.2, 15.0), "gain at low frequencies, of the integral aside",
        symbol="K", scale="log", exclusive=True, integrals=0,
    ),
    row(
        "t_i", "s", Span(1.0, 0.05, 20.0), Span(8.0, 0.2, 60.0), "integral time, 0 for no integral", symbol="Ti",
        scale="log", term="integral term",
    ),
    row(
        "zero", "rad/s", Span(4.0, 0.5, 50.0), Span(0.7, 0.1, 10.0), "corner of the numerator", symbol="z", scale="log",
        exclusive=True,
    ),
    row(
        "pole", "rad/s", Span(60.0, 5.0, 300.0), Span(12.0, 1.0, 60.0), "corner of the denominator", symbol="p",
        scale="log", exclusive=True,
    ),
    row(
        "notch", "Hz", Span(0.0, 0.0, 120.0), Span(0.0, 0.0, 40.0), "centre of the notch, 0 for none", symbol="fn",
        cutoff=True, optional=True,
    ),
    row(
        "notch_width", "Hz", Span(20.0, 5.0, 50.0), Span(5.0, 1.0, 20.0),
        "width of the notch, between the frequencies where it is 3 dB down", symbol="df", cutoff=True,
    ),
)  # fmt: skip

LAW = Law(
    name="lead_lag",
    title="lead-lag compensator with integral and notch",
    blocks=Blocks("lead-lag, notch, integral"),
    source=SOURCE,
    Gains=Gains,
    Constants=Constants,
    Memory=Memory,
    prepare=prepare,
    start=start,
    step=step,
    gains=GAINS,
    sampling="lead and notch: bilinear, the notch exact at its centre; integral: forward Euler, in force one period after it is "
    "formed",
    promises=frozenset(),
)
