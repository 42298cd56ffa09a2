"""Conditions as the paper prints them, for the tests that show what is wrong with them.

Wu et al., Appl. Sci. 2025, 15(9), 5124, section 2.3.3: the conditions at the end of the Lyapunov proof, and (31).
"""

from typing import NamedTuple

import numpy as np

from tuner.extensions.theory.theorems.theorem import Array


class SurfaceGains(NamedTuple):
    """k1 [y^(1/2) s^(-3/2)], k2 [1/s]."""

    k1: Array
    k2: Array


def printed_least_gains(s: Array, residual: float, delta: float) -> SurfaceGains:
    """Return what the proof asks k1 and k2 to exceed at |S| = s [y/s] for a residual |eps| [y/s2].

    It asks for the maximum over all s, and near 0, where |S| <= delta, both grow without limit. Either of the two alone would
    make V' <= 0 there, so asking for both is no remedy. Outside delta a factor |S| too many is left standing on the right.
    """
    inside = s <= delta
    k1 = np.where(inside, residual * delta * s**-1.5, residual * np.sqrt(s))
    return SurfaceGains(k1, np.where(inside, residual / s, residual))


def printed_31_bound(k1: Array, k2: Array, alpha: float = 1.0) -> Array:
    """Return the largest eps that (31) admits: k1 > 2 eps/alpha, k2 > eps/alpha^2, alpha "typically set to 1".

    Its two sides have different units: scaled by c and c^2, gains of a super-twisting law bear c^2 times the disturbance rate,
    and this says otherwise. For small eps it accepts gains that do not converge.
    """
    return np.minimum(0.5 * alpha * k1, alpha**2 * k2)
