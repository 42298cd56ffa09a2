"""ADRC with a true super-twisting term in place of the paper's power-rate and proportional terms.

    e = y - r,   S = e' + lambda e
    b0 u = -z3 + r'' - lambda e' - k1 |S|^(1/2) sgn S + v,   v' = -k2 sgn S
    z1' = z2 + 3 wo (y - z1),   z2' = z3 + b0 u + 3 wo^2 (y - z1),   z3' = wo^3 (y - z1)

Use it where what an observer misses of the disturbance shall be rejected in finite time, not only kept small.

What Wu et al., Appl. Sci. 2025, 15(9), 5124, section 2.3.2, describe before section 2.3.3 replaces the integral by -k2 S. The
observer takes the bulk of the disturbance away; what it misses has a bounded derivative, and S is driven to 0 in finite time
where k2 exceeds that bound. Sampled without chatter and kept from winding up as in `twisting`.
"""

from dataclasses import replace
from typing import NamedTuple

from plant.laws import hybrid_gsta, supertwisting
from plant.laws.hybrid_gsta import Constants
from plant.laws.ladrc import OMEGA_O
from plant.laws.law import Blocks, SuperTwisting
from plant.laws.observer import observer_constants
from plant.laws.twisting import twist_constants


class Gains(NamedTuple):
    """omega_o [rad/s], lambda_ [1/s], k1 [y^(1/2) s^(-3/2)], k2 [y/s3]."""

    omega_o: float
    lambda_: float
    k1: float
    k2: float


def prepare(gains: Gains, h: float) -> Constants:
    """Sample the observer and the super-twisting term."""
    term = twist_constants(gains.k1, gains.k2, 0.0, h)
    return Constants(observer_constants(gains.omega_o, h), gains.lambda_, term)


LAW = replace(
    hybrid_gsta.LAW,
    name="hybrid_true_sta",
    title="ADRC with a true super-twisting term",
    blocks=Blocks("surface S, super-twisting, minus z3", measured="linear ESO", takes_command=True),
    source=supertwisting.SOURCE,
    Gains=Gains,
    prepare=prepare,
    gains=(OMEGA_O, hybrid_gsta.LAMBDA, supertwisting.K1, supertwisting.K2),
    super_twisting=SuperTwisting("k1", "k2"),
)
