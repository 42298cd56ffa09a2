"""What the gain conditions of super-twisting share: which laws they speak of, and how a theorem is made of one.

    S' = -k1 |S|^(1/2) sgn S + v + d(t),   v' = -k2 sgn S,   |d'| <= L

Each condition is turned round into the number that a requirement wants: the supremum of the rates L that the gains (k1, k2)
are guaranteed to bear, S = S' = 0 being reached in finite time; 0 where they bear none. All of them scale as the equation
does: c k1 and c^2 k2 bear c^2 L.

Behind an observer, d is what it misses: e3 = d - z3, whose rate can be twice that of the disturbance, because the kernel from
d' to e3' is an impulse of area 1 less a positive one of area 1 (wo^3 t^2/2 exp(-wo t)). So there a law bears half of L. A
disturbance that turns from -L to L after a long time reaches the 2 L.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from objectives.theory.theorem import Array, Setting, Theorem, Value

Rate = Callable[[Array, Array], Array]
"""From k1 [y^(1/2) s^(-3/2)] and k2 [y/s3] to the largest rate that is borne [y/s3]."""

PLAIN = ("supertwisting", "supertwisting_euler")
OBSERVED = "hybrid_true_sta"
OBSERVER_STRETCH = 2.0
QUANTITY = "fastest disturbance under which the sliding variable is guaranteed to reach 0"
ASSUMES = "continuous time, no actuator lag, no noise and a reference of known rate: what flies comes near 0, not to it"


def plain(rate: Rate) -> Value:
    """Return the condition as the value of a law that meets the disturbance itself."""

    def value(gains: Any, setting: Setting) -> Array:
        return rate(np.asarray(gains.k1, dtype=np.float64), np.asarray(gains.k2, dtype=np.float64))

    return value


def observed(rate: Rate) -> Value:
    """Return the condition as the value of a law that meets what its observer misses."""
    met = plain(rate)
    return lambda gains, setting: met(gains, setting) / OBSERVER_STRETCH


def condition(name: str, title: str, source: str, rate: Rate, generalised: bool = False) -> Theorem:
    """Return a gain condition as a theorem; generalised: it also covers the law with linear parts, whatever their share."""
    values = dict.fromkeys(PLAIN, plain(rate)) | {OBSERVED: observed(rate)}
    return Theorem(
        name=name,
        title=title,
        source=source,
        quantity=QUANTITY,
        unit="{y}/s^3",
        sense="least",
        values=values | ({"hybrid_gsta": observed(rate)} if generalised else {}),
        needs_rate=False,
        measured_rate=True,
        assumes=ASSUMES,
    )
