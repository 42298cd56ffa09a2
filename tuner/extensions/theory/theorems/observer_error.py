"""Exact error bounds of the linear extended state observer.

The disturbance has a bounded rate, |d'| <= L.
Continuous observer, poles -wo three times (Z. Gao, ACC 2003): the impulse responses from d' to the errors e1 of y, e2 of
y' and e3 of d are positive, so their L1 norms are their DC gains and a ramp reaches them:

    |e1| <= L/wo^3,   |e2| <= 3 L/wo^2,   |e3| <= 3 L/wo

The flown observer is the sampled current estimator (`plant.laws.observer`). Its impulse responses are positive too, and with
c = coth(wo h/2) the same argument gives, right after each measurement,

    |e1| <= L h^3 ((c - 1)/2)^3,   |e2| <= L h^2 (3 c (c - 1)/4 + 1/3),   |e3| <= L h (3 c - 1)/2

and |e3| <= L h (3 c + 1)/2 over the whole period that follows, in which z3 is held. For h -> 0 these are the continuous ones.
At wo h = 0.3, the fastest observer that a study admits, they are 0.631, 0.874, 0.957 and, held, 1.057 times as large: only
the last is not on the safe side of the continuous formula, and it is the one that drives the loop. So the sampled bounds
are the ones used, for e3 the held one.

Exact for noiseless y and an input acceleration that is known and constant within the period; lag and delay that the
controller does not model are part of d.
"""

from collections.abc import Callable

import numpy as np

from plant.law_registry import LAWS
from plant.laws.observer import triple_pole
from tuner.extensions.theory.theorems.theorem import Array, Setting, Theorem

THREE_POLES = tuple(name for name, entry in LAWS.items() if entry.observer is triple_pole)
"""Names of the laws whose linear observer has its three poles in one place."""
SOURCE = "Gao, ACC 2003; L1 norms of the sampled observer worked out here"
ASSUMES = "no measurement noise; what the controller does not know of the actuators counts as disturbance"


def cotangent(omega_o: Array, period: float) -> Array:
    """Return c = coth(wo h/2).

    It is (1 + beta)/(1 - beta) of the sampled pole beta = exp(-wo h).
    """
    return 1.0 / np.tanh(0.5 * period * omega_o)


def value_bound(omega_o: Array, setting: Setting) -> Array:
    """Return the bound on |e1| [y] at the control instants."""
    return setting.rate * (setting.period / np.expm1(setting.period * omega_o)) ** 3


def rate_bound(omega_o: Array, setting: Setting) -> Array:
    """Return the bound on |e2| [y/s] at the control instants."""
    c = cotangent(omega_o, setting.period)
    return setting.rate * setting.period**2 * (0.75 * c * (c - 1.0) + 1.0 / 3.0)


def disturbance_bound(omega_o: Array, setting: Setting) -> Array:
    """Return the bound on |e3| [y/s2] over the whole of every period."""
    return setting.rate * setting.period * (1.5 * cotangent(omega_o, setting.period) + 0.5)


def _bound(name: str, title: str, quantity: str, unit: str, bound: Callable[[Array, Setting], Array]) -> Theorem:
    return Theorem(
        name=name,
        title=f"error of the observed {title}",
        source=SOURCE,
        quantity=f"bound on the observer's error in {quantity}",
        unit=unit,
        sense="max",
        values=dict.fromkeys(THREE_POLES, lambda gains, setting: bound(gains.omega_o, setting)),
        needs_rate=True,
        measured_rate=False,
        assumes=ASSUMES,
    )


VALUE = _bound("observer_value", "y", "y", "{y}", value_bound)
RATE = _bound("observer_rate", "rate of y", "the rate of y", "{y}/s", rate_bound)
DISTURBANCE = _bound(
    "observer_disturbance", "disturbance", "the disturbance, held over the period", "{y}/s^2", disturbance_bound
)
