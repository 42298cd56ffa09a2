"""ADRC with a power-rate and a proportional sliding term: the paper's A-ST-SMC, corrected.

    e = y - r,   S = e' + lambda e,   sat(x) = max(-1, min(1, x))
    b0 u = -z3 + r'' - lambda e' - k1 |S|^(1/2) sat(S/delta) - k2 S
    z1' = z2 + 3 wo (y - z1),   z2' = z3 + b0 u + 3 wo^2 (y - z1),   z3' = wo^3 (y - z1)

Use it to fly the paper's method. With k1 = 0 and a measured rate it is `ladrc` with wc^2 = lambda k2 and 2 zeta wc = lambda + k2.

Wu et al., Appl. Sci. 2025, 15(9), 5124, section 2.3.3, with the signs, the equivalent-control terms r'' - lambda e' and the
second case of sat restored, and z3 alone as the estimate of f + d (z2 estimates the rate). It is no super-twisting law: the
integral of the sign is replaced by -k2 S, so S is driven into a band, not to zero in finite time. Linear in S it is a PD law
with kp = lambda k, kd = lambda + k, where k grows from k2 at small amplitude to at most k2 + 0.93 k1/sqrt(delta).
"""

from typing import NamedTuple

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.continuous import ContinuousForm, on_observer
from plant.laws.ladrc import OMEGA_O, start
from plant.laws.law import Blocks, GainInfo, Law, Nonlinearity, Span
from plant.laws.observer import (
    FEEDBACK,
    SAMPLING,
    Observer,
    ObserverConstants,
    observe,
    observer_constants,
    triple_pole,
)
from plant.laws.surface import surface
from plant.primitives import absolute, clip, sqrt

SOURCE = "Wu et al., Appl. Sci. 2025, 15(9), 5124"
FAMILY = "ADRC with power-rate and proportional sliding term"


class Gains(NamedTuple):
    """omega_o [rad/s], lambda_ [1/s], k1 [y^(1/2) s^(-3/2)], k2 [1/s], delta [y/s]."""

    omega_o: float
    lambda_: float
    k1: float
    k2: float
    delta: float


class Constants(NamedTuple):
    """The gains, with those of the observer sampled."""

    observer: ObserverConstants
    lambda_: float
    k1: float
    k2: float
    per_delta: float


def prepare(gains: Gains, h: float) -> Constants:
    """Sample the observer."""
    observer = observer_constants(gains.omega_o, h)
    return Constants(observer, gains.lambda_, gains.k1, gains.k2, 1.0 / gains.delta)


def sliding_term(s: float, constants: Constants) -> float:
    """k1 |S|^(1/2) sat(S/delta) + k2 S."""
    return constants.k1 * sqrt(absolute(s)) * clip(s * constants.per_delta, -1.0, 1.0) + constants.k2 * s


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
    e = surface(constants.lambda_, channel, setpoint, measured, z.z2)
    demand = setpoint.acceleration - constants.lambda_ * e.error_rate - sliding_term(e.s, constants)
    return (demand - z.z3) / channel.b0, z


def linear_part(
    gains: Gains,
    from_observer: bool,
    polynomial: tuple[float, float, float],
    equivalent: float = 1.0,
    estimate: float = 0.0,
) -> ContinuousForm:
    """Return the form of u = -lambda e' - k2 S - z3, S = e' + lambda e; the power-rate term is left out. States: z1 to z3.

    Of the paper as printed: equivalent = 0 leaves lambda e' out, estimate = 1 takes z2 off too.
    """
    lam, k2 = gains.lambda_, gains.k2
    # Shares of z2 and of the measured rate in the rate that the law takes.
    observed, measured = float(from_observer), float(not from_observer)
    given = equivalent * lam
    estimates = (0.0, -(given + k2) * observed - estimate, -1.0)
    values = (k2 * lam, -k2 * lam, -given * measured - k2 * measured, 0.0)
    return on_observer(polynomial, (estimates, (0.0, observed, 0.0)), (values, (-lam, lam, measured, 0.0)))


def continuous(gains: Gains, from_observer: bool) -> ContinuousForm:
    """Return the continuous form without the power-rate term."""
    return linear_part(gains, from_observer, triple_pole(gains.omega_o))


def sector(gains: Gains) -> float:
    """Return kappa [1/s]: the secant of k1 |S|^(1/2) sat(S/delta) is largest where the saturation sets in, k1/sqrt(delta)."""
    return gains.k1 / sqrt(gains.delta)


LAW = Law(
    name="hybrid",
    title="ADRC with power-rate and proportional sliding term (A-ST-SMC, corrected)",
    blocks=Blocks("surface S, power rate, minus z3", measured="linear ESO", takes_command=True),
    source=SOURCE,
    Gains=Gains,
    Constants=Constants,
    Memory=Observer,
    prepare=prepare,
    start=start,
    step=step,
    gains=(
        OMEGA_O,
        GainInfo(
            "lambda_", "lambda", "s^-1", Span(5.0, 0.5, 20.0), Span(1.0, 0.2, 5.0), "log", SOURCE,
            "slope of the sliding surface; open in the source", exclusive=True,
        ),
        GainInfo(
            "k1", "k1", "{y}^(1/2) s^(-3/2)", Span(20.0, 0.0, 40.0), Span(0.5, 0.0, 5.0), "linear", SOURCE,
            "power-rate gain", term="power-rate term",
        ),
        GainInfo(
            "k2", "k2", "s^-1", Span(5.0, 0.5, 80.0), Span(1.0, 0.1, 8.0), "log", SOURCE,
            "proportional gain on the sliding variable; open in the source", term="proportional sliding term",
        ),
        GainInfo(
            "delta", "delta", "{y}/s", Span(0.1, 0.01, 1.0), Span(0.2, 0.02, 2.0), "log", SOURCE,
            "half-width of the saturation; open in the source", exclusive=True,
        ),
    ),
    nonlinear=(Nonlinearity("sliding term", sliding_term, "{y}/s"),),
    sampling=f"{SAMPLING}; {FEEDBACK}",
    family=FAMILY,
    observer=triple_pole,
    continuous=continuous,
    sector=sector,
)  # fmt: skip
