"""The region of super-twisting gains that a quadratic Lyapunov function certifies; also for the generalized algorithm.

V = zeta' P zeta, zeta = (|S|^(1/2) sgn S, v + d), falls under every |d'| <= L where a linear matrix inequality in P has a
solution; by the Kalman-Yakubovich-Popov lemma that is L |(1/2)/(s^2 + (k1/2) s + k2/2)| < 1 on the imaginary axis, so

    L < k2   if k1^2 >= 4 k2,   else   L < (k1/4) (8 k2 - k1^2)^(1/2)

J. A. Moreno, M. Osorio, "Strict Lyapunov functions for the super-twisting algorithm", IEEE Trans. Automatic Control
57(4):1035-1040, 2012; the closed form was worked out here and agrees with the inequality solved numerically. It does not
accept the usual 1.5 L^(1/2), 1.1 L, which bear only 0.9597 L by it; 1.602 L^(1/2), 1.1 L pass.

Linear parts (J. A. Moreno, CCE 2009, mu > 0) only help: with phi1 for the root, d'/phi1' is at most 2 L |phi1| still, so the
same inequality does for every mu.
"""

import numpy as np

from tuner.extensions.theory.theorems.theorem import Array
from tuner.extensions.theory.theorems.twisting_conditions import condition


def moreno_osorio_rate(k1: Array, k2: Array) -> Array:
    """Return the largest rate borne [y/s3]."""
    resonant = 0.25 * k1 * np.sqrt(np.maximum(8.0 * k2 - k1**2, 0.0))
    return np.where(k1**2 >= 4.0 * k2, k2, resonant)


MORENO_OSORIO = condition(
    "sta_moreno_osorio",
    "Moreno and Osorio's quadratic Lyapunov function",
    "Moreno, Osorio, IEEE TAC 57(4):1035-1040, 2012",
    moreno_osorio_rate,
    generalized=True,
)
