"""PID without a filter on the derivative: b0 u = r'' + kp e + I + kd e', I' = ki e + (ki/kp) b0 excess, e = r - y."""

from typing import NamedTuple

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.law import GainInfo, Law, Span

SOURCE = "Astrom, Hagglund, Advanced PID Control, ISA 2006, section 3.2"


class Gains(NamedTuple):
    """kp [1/s2], ki [1/s3], kd [1/s]."""

    kp: float
    ki: float
    kd: float


class Memory(NamedTuple):
    """integral [y/s2]."""

    integral: float


def prepare(gains: Gains, h: float) -> Gains:  # noqa: ARG001
    """Work out once a flight what does not change; here nothing."""
    return gains


def start(constants: Gains, measured: Measured, held: float) -> Memory:  # noqa: ARG001
    """At rest: the integral holds the plant."""
    return Memory(held)


def step(
    memory: Memory,
    constants: Gains,
    channel: Channel,
    setpoint: Setpoint,
    measured: Measured,
    applied: Applied,
    h: float,
) -> tuple[float, Memory]:
    """One control period; the integral takes effect one period after it is formed."""
    error, rate = setpoint.value - measured.value, setpoint.rate - measured.rate
    integral = memory.integral + h * constants.ki / constants.kp * channel.b0 * applied.excess
    demand = setpoint.acceleration + constants.kp * error + integral + constants.kd * rate
    return demand / channel.b0, Memory(integral + h * constants.ki * error)


LAW = Law(
    name="pid_plain",
    title="PID without a derivative filter",
    source=SOURCE,
    Gains=Gains,
    Constants=Gains,
    Memory=Memory,
    prepare=prepare,
    start=start,
    step=step,
    gains=(
        GainInfo(
            "kp", "kp", "s^-2", Span(60.0, 5.0, 400.0), Span(2.5, 0.2, 20.0), "log", SOURCE,
            "acceleration per error", exclusive=True,
        ),
        GainInfo(
            "ki", "ki", "s^-3", Span(60.0, 0.1, 2000.0), Span(0.6, 0.01, 20.0), "log", SOURCE,
            "acceleration per integrated error",
        ),
        GainInfo(
            "kd", "kd", "s^-1", Span(14.0, 2.0, 60.0), Span(2.6, 0.4, 15.0), "log", SOURCE,
            "acceleration per rate",
        ),
    ),
    sampling="integral: forward Euler, in force one period after it is formed",
)  # fmt: skip
