"""The hybrid law on the printed observer: beta3 = 3 wo^3 where three poles at -wo need wo^3.

    e = y - r,   S = e' + lambda e,   sat(x) = max(-1, min(1, x))
    b0 u = -z3 + r'' - lambda e' - k1 |S|^(1/2) sat(S/delta) - k2 S
    z1' = z2 + 3 wo (y - z1),   z2' = z3 + b0 u + 3 wo^2 (y - z1),   z3' = 3 wo^3 (y - z1)
    s^3 + 3 wo s^2 + 3 wo^2 s + 3 wo^3 = (s + wo)^3 + 2 wo^3 = 0   at   s = -wo - 2^(1/3) wo (1, -1/2 +- j sqrt(3)/2)

Use it to test the paper's claims alone.

Wu et al., Appl. Sci. 2025, 15(9), 5124, section 2.3.3; its table 2 (30, 300, 1000) has wo^3. The poles -2.2599 wo and
(-0.3700 +- 1.0911j) wo are stable but ring, with a damping ratio of 0.32. Sampled as the current estimator of `observer`
with its poles at exp(s h).
"""

from dataclasses import replace

from plant.laws import hybrid
from plant.laws.continuous import ContinuousForm
from plant.laws.hybrid import Constants, Gains, linear_part
from plant.laws.law import Blocks
from plant.laws.observer import FEEDBACK, ObserverConstants, placed, triple_pole
from plant.primitives import cos, exp, sin

# Poles over -wo: 1 + 2^(1/3); real and imaginary part of the pair, 1 - 2^(1/3)/2 and 2^(1/3) sqrt(3)/2.
REAL_POLE, DECAY, RINGING = 2.2599210498948734, 0.3700394750525634, 1.0911236359717214


def printed_observer(omega_o: float, h: float) -> ObserverConstants:
    """Sample the observer whose continuous gains are 3 wo, 3 wo^2 and 3 wo^3."""
    size, angle = exp(-DECAY * omega_o * h), RINGING * omega_o * h
    ahead, aside = 1.0 - size * cos(angle), size * sin(angle)
    return placed(1.0 - exp(-REAL_POLE * omega_o * h), 2.0 * ahead, ahead * ahead + aside * aside, h)


def printed_polynomial(omega_o: float) -> tuple[float, float, float]:
    """Return the observer's gains as printed, 3 wo, 3 wo^2 and 3 wo^3."""
    b1, b2, b3 = triple_pole(omega_o)
    return b1, b2, 3.0 * b3


def continuous(gains: Gains, from_observer: bool) -> ContinuousForm:
    """Return the continuous form without the power-rate term."""
    return linear_part(gains, from_observer, printed_polynomial(gains.omega_o))


def prepare(gains: Gains, h: float) -> Constants:
    """Sample the observer."""
    observer = printed_observer(gains.omega_o, h)
    return Constants(observer, gains.lambda_, gains.k1, gains.k2, 1.0 / gains.delta)


LAW = replace(
    hybrid.LAW,
    name="hybrid_beta3",
    title="A-ST-SMC with the printed observer gain beta3 = 3 wo^3",
    blocks=Blocks("surface S, power rate, minus z3", measured="printed ESO", takes_command=True),
    prepare=prepare,
    sampling=(
        "observer: current estimator for a held input, poles at exp(p h) for the roots p of "
        f"s^3 + 3 wo s^2 + 3 wo^2 s + 3 wo^3; {FEEDBACK}"
    ),
    family="",
    observer=printed_polynomial,
    continuous=continuous,
)
