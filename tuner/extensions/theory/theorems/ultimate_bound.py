"""Ultimate bound on the error of the paper's hybrid law.

The error does not converge to zero.
With S = e' + lambda e and the law of `plant.laws.hybrid`, S' = eps(t) - k1 |S|^(1/2) sat(S/delta) - k2 S, where eps is what
the observer misses of the disturbance, |eps| <= E. So |S| falls until it is below the one S* >= 0 of

    k1 S*^(1/2) min(S*/delta, 1) + k2 S* = E,   and then   limsup |e| <= S*/lambda

Wu et al., Appl. Sci. 2025, 15(9), 5124, claim asymptotic stability instead, under conditions that no finite gains satisfy; this
is what their Lyapunov function does prove. E is not assumed as there but follows from the observer's bandwidth,
`observer_error.disturbance_bound`. A ramp of disturbance reaches the bound.

Not covered, in flight: noise, and a reference of unknown rate, as the tilt that a position loop asks
for. A Hummingbird with 20 ms of rotor lag in light turbulence, bound 0.0046 rad in roll, 64 flights of 4 s: its largest
roll error was 0.0019 rad on average (99 % quantile 0.0051) where it held its attitude without noise, 0.012 where it held its
position, and 0.018 with the usual sensor noise. So it ranks gains; it is no figure for a flight.

Smaller delta lowers S*: |S|^(1/2) is continuous without sat, which only weakens the term near zero.
"""

import numpy as np

from plant.law_registry import LAWS
from plant.laws import hybrid
from tuner.extensions.theory.theorems.observer_error import disturbance_bound
from tuner.extensions.theory.theorems.theorem import Array, Setting, Theorem

# Newton's steps on a convex cubic from above: 5 reach the last bit from the worst start, where both terms are equal.
STEPS = 8


def ultimate_surface(k1: Array, k2: Array, delta: Array, residual: Array) -> Array:
    """Return S* [y/s] for |eps| <= residual [y/s2]; infinite where k1 = k2 = 0 and the residual is not 0."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        beyond = _root_beyond(k1, k2, residual)
        within = _root_within(k1 / delta, k2, residual)
        root = np.where(beyond**2 >= delta, beyond, within)
    return np.where(residual > 0.0, root**2, 0.0)


def _root_beyond(k1: Array, k2: Array, residual: Array) -> Array:
    """Return S*^(1/2) where sat = 1: the positive root of k2 r^2 + k1 r = residual, free of cancellation."""
    return 2.0 * residual / (k1 + np.sqrt(k1**2 + 4.0 * k2 * residual))


def _root_within(a: Array, k2: Array, residual: Array) -> Array:
    """Return S*^(1/2) where sat = S/delta: the positive root of a r^3 + k2 r^2 = residual.

    Each term alone gives a start above the root; from there Newton's steps fall onto it, because the left side is convex.
    """
    r = np.minimum(np.cbrt(residual / a), np.sqrt(residual / k2))
    for _ in range(STEPS):
        r = r - (a * r**3 + k2 * r**2 - residual) / (3.0 * a * r**2 + 2.0 * k2 * r)
    return r


def ultimate_error(gains: hybrid.Gains, setting: Setting) -> Array:
    """Return the bound [y] that |e| ends below."""
    omega_o, lambda_, k1, k2, delta = (np.asarray(gain, dtype=np.float64) for gain in gains)
    return ultimate_surface(k1, k2, delta, disturbance_bound(omega_o, setting)) / lambda_


ULTIMATE_ERROR = Theorem(
    name="ultimate_error",
    title="ultimate bound of the hybrid law",
    source="Wu et al., Appl. Sci. 2025, 15(9), 5124, section 2.3.3, proof corrected",
    quantity="bound that the error ends below",
    unit="{y}",
    sense="max",
    values={entry.name: ultimate_error for entry in LAWS.values() if entry.family == hybrid.FAMILY},
    needs_rate=True,
    measured_rate=True,
    assumes="no noise, a reference of known rate (a tilt that the position loop asks for is none), and feedback much slower "
    "than control period and actuators, which do not saturate",
)
