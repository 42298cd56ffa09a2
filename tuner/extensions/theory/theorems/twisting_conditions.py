"""Common part of the gain conditions of super-twisting: the laws that they speak of, and a theorem made of a condition.

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

from plant.law_registry import LAWS
from plant.laws.law import SuperTwisting
from tuner.extensions.theory.theorems.theorem import Array, Setting, Theorem, Value

Rate = Callable[[Array, Array], Array]
"""From k1 [y^(1/2) s^(-3/2)] and k2 [y/s3] to the largest rate that is borne [y/s3]."""

OBSERVER_STRETCH = 2.0
QUANTITY = "fastest disturbance under which the sliding variable is guaranteed to reach 0"
ASSUMES = "continuous time, no actuator lag, no noise and a reference of known rate: what flies comes near 0, not to it"


def value_of(rate: Rate, term: SuperTwisting, observed: bool) -> Value:
    """Return the condition as the value of a law with that term; observed: whether it meets only what its observer misses."""

    def value(gains: Any, setting: Setting) -> Array:  # noqa: ARG001
        k1, k2 = (np.asarray(getattr(gains, name), dtype=np.float64) for name in (term.k1, term.k2))
        return rate(k1, k2) / OBSERVER_STRETCH if observed else rate(k1, k2)

    return value


def values_by_law(rate: Rate, generalized: bool) -> dict[str, Value]:
    """Return the condition for every law with a super-twisting term; with linear parts only where it is `generalized`."""
    return {
        entry.name: value_of(rate, entry.super_twisting, entry.observer is not None)
        for entry in LAWS.values()
        if entry.super_twisting is not None and (generalized or not entry.super_twisting.mu)
    }


def condition(name: str, title: str, source: str, rate: Rate, generalized: bool = False) -> Theorem:
    """Return a gain condition as a theorem; generalized: it also covers the law with linear parts, whatever their share."""
    return Theorem(
        name=name,
        title=title,
        source=source,
        quantity=QUANTITY,
        unit="{y}/s^3",
        sense="min",
        values=values_by_law(rate, generalized),
        needs_rate=False,
        measured_rate=True,
        assumes=ASSUMES,
    )
