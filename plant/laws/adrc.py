"""Nonlinear active disturbance rejection after Han: tracking differentiator, nonlinear ESO, nonlinear state error feedback.

    e1 = v1 - z1,   e2 = v2 - z2,   kp = wc^2,   kd = 2 zeta wc
    b0 u = u0 - z3,   u0 = r'' + kp delta1^(1/4) fal(e1, 3/4, delta1) + kd delta2^(-1/2) fal(e2, 3/2, delta2)
    v1' = v2,   v2' = r'' + fhan(v1 - r, v2 - r', r0, 5 h)
    z1' = z2 + 3 wo e,   z2' = z3 + b0 u + 3 wo^2 delta0^(1/2) fal(e, 1/2, delta0),   z3' = wo^3 delta0^(3/4) fal(e, 1/4, delta0)
    e = y - z1,   fal(e, a, delta) = |e|^a sgn e outside |e| <= delta, e/delta^(1-a) inside

Use it where references jump, or where errors grow so large that linear gains saturate the actuators; small errors meet `ladrc`.

J. Han, "From PID to active disturbance rejection control", IEEE Trans. Ind. Electron. 56(3), 2009, pp. 900-906. Wu et al.,
Appl. Sci. 2025, 15(9), 5124, section 2.3.1, print its parts but not u = (u0 - z3)/b0, which closes the loop. With the
measured rate, y and its measured rate stand in for z1 and z2, as in `ladrc`.

Gains by meaning: while |e1| <= delta1, |e2| <= delta2 and the innovation of the observer stays within delta0, this is `ladrc`
with the same omega_o, omega_c and zeta behind the tracking differentiator: kp = wc^2, kd = 2 zeta wc, and Han's
beta02 delta0^(-1/2) and beta03 delta0^(-3/4) are the gains of the linear observer. Beyond, an error counts for less and its
rate for more. r0 bounds the acceleration with which a jump of the reference is passed on; the period of fhan is five control
periods, so that a reference whose rate is not known comes ten control periods late.
"""

from typing import NamedTuple

from plant.laws import ladrc, nonlinear_observer
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.fal import fal_3_2, fal_3_4
from plant.laws.law import Blocks, GainInfo, Law, Nonlinearity, Span
from plant.laws.nonlinear_observer import NonlinearObserverConstants, observe_nonlinearly
from plant.laws.observer import FEEDBACK, Observer, observer_constants
from plant.laws.tracking_differentiator import Profile, track
from plant.primitives import select

SOURCE = "Han, IEEE Trans. Ind. Electron. 56(3), 2009"
# h0 of the tracking differentiator in control periods.
FILTER_PERIODS = 5.0


class Gains(NamedTuple):
    """omega_c [rad/s], zeta [1], omega_o [rad/s], delta_1 [y], delta_2 [y/s], delta_0 [y], r_0 [y/s2]."""

    omega_c: float
    zeta: float
    omega_o: float
    delta_1: float
    delta_2: float
    delta_0: float
    r_0: float


class Constants(NamedTuple):
    """kp [1/s2], kd [1/s], the linear zones delta_1 [y] and delta_2 [y/s], the observer, r_0 [y/s2] and h_0 [s]."""

    kp: float
    kd: float
    delta_1: float
    delta_2: float
    observer: NonlinearObserverConstants
    r_0: float
    h_0: float


class Memory(NamedTuple):
    """State of the observer and of the tracking differentiator."""

    observer: Observer
    profile: Profile


def prepare(gains: Gains, h: float) -> Constants:
    """Work out the gains of the linear zone: kp = wc^2, kd = 2 zeta wc, the sampled linear observer."""
    wc = gains.omega_c
    observer = NonlinearObserverConstants(observer_constants(gains.omega_o, h), gains.delta_0)
    return Constants(
        wc * wc, 2.0 * gains.zeta * wc, gains.delta_1, gains.delta_2, observer, gains.r_0, FILTER_PERIODS * h
    )


def start(constants: Constants, measured: Measured, held: float) -> Memory:
    """Start observer and profile at the measurement, the disturbance what is held against."""
    return Memory(Observer(measured.value, measured.rate, 0.0 - held), Profile(measured.value, measured.rate))


def error_term(e1: float, constants: Constants) -> float:
    """Acceleration asked for by an error [y]."""
    return constants.kp * fal_3_4(e1, constants.delta_1)


def rate_term(e2: float, constants: Constants) -> float:
    """Acceleration asked for by an error of the rate [y/s]."""
    return constants.kd * fal_3_2(e2, constants.delta_2)


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
    v, ahead = track(memory.profile, setpoint, constants.r_0, constants.h_0, h)
    z = observe_nonlinearly(memory.observer, constants, measured.value, channel.b0 * applied.effect, h)
    from_observer = channel.rate_from_observer > 0.5
    value = select(from_observer, z.z1, measured.value)
    rate = select(from_observer, z.z2, measured.rate)
    demand = error_term(v.v1 - value, constants) + rate_term(v.v2 - rate, constants) + setpoint.acceleration
    return (demand - z.z3) / channel.b0, Memory(z, ahead)


OMEGA_C, ZETA, OMEGA_O = ladrc.LAW.gains

LAW = Law(
    name="adrc",
    title="nonlinear ADRC after Han",
    blocks=Blocks("nonlinear PD, minus z3", reference="tracking differentiator", measured="nonlinear ESO", takes_command=True),
    source=SOURCE,
    Gains=Gains,
    Constants=Constants,
    Memory=Memory,
    prepare=prepare,
    start=start,
    step=step,
    gains=(
        OMEGA_C,
        ZETA,
        OMEGA_O,
        GainInfo(
            "delta_1", "delta1", "{y}", Span(0.2, 0.02, 2.0), Span(1.0, 0.1, 10.0), "log", SOURCE,
            "half-width of the linear zone of the error feedback", exclusive=True,
        ),
        GainInfo(
            "delta_2", "delta2", "{y}/s", Span(1.0, 0.1, 10.0), Span(1.0, 0.1, 10.0), "log", SOURCE,
            "half-width of the linear zone of the rate feedback", exclusive=True,
        ),
        GainInfo(
            "delta_0", "delta0", "{y}", Span(0.05, 0.005, 0.5), Span(0.1, 0.01, 1.0), "log", SOURCE,
            "half-width of the linear zone of the observer", exclusive=True,
        ),
        GainInfo(
            "r_0", "r0", "{y} s^-2", Span(400.0, 20.0, 4000.0), Span(5.0, 0.5, 50.0), "log", SOURCE,
            "acceleration with which a jump of the reference is passed on", exclusive=True,
        ),
    ),
    nonlinear=(
        Nonlinearity("error term", error_term, "{y}"),
        Nonlinearity("rate term", rate_term, "{y}/s"),
        *nonlinear_observer.NONLINEAR,
    ),
    sampling=(
        "tracking differentiator: fhan of the period 5 h; observer: current estimator for a held input with fal corrections, "
        f"three poles at exp(-omega_o h) in the linear zone; {FEEDBACK}"
    ),
)  # fmt: skip
