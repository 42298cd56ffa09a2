"""Super-twisting: the quadratic certificate of finite-time convergence, and the largest disturbance rate it covers.

    S' = -k1 |S|^(1/2) sign S + v,   v' = -k2 sign S + d',   |d'| <= L

With zeta = (|S|^(1/2) sign S, v) it is zeta' = |zeta_1|^-1 (A zeta + B rho), |rho| <= L |zeta_1|, and V = zeta' P zeta falls
if [[A'P + PA + tau L^2 C'C, PB], [B'P, -tau]] < 0 for some P > 0, tau > 0. J. A. Moreno, M. Osorio, "Strict Lyapunov
functions for the super-twisting algorithm", IEEE Trans. Automatic Control 57(4), 2012, pp. 1035-1040.

It holds for the generalized law too, phi1 = |S|^(1/2) sign S + mu S and v' = -2 k2 phi1 phi1': |d'| <= L is at most
2 L |phi1 phi1'| there. d is what the surface still meets: with an observer in the law, what that misses. Of the law in
continuous time, without lag. Sufficient only: for the popular k1 = 1.5 sqrt(L), k2 = 1.1 L, which is known to converge, there
is no such P; it takes k1 = 1.6022 sqrt(L).
"""

from dataclasses import dataclass
from math import sqrt
from typing import Any

import cvxpy as cp
import numpy as np

from objectives import lmi
from objectives.linear_axis.channel_model import Loop
from plant.law_registry import LAWS, law
from tuner.extensions.certificates.certificate import Certificate, CertificateInfo, inconclusive

Array = np.ndarray

B, C = np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]])
RATE_UNIT = "{y}/s3"
# The largest rate is approached from below by these shares until the eigenvalues agree.
BACK_OFF = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2)


@dataclass(frozen=True)
class Scaled:
    """The law with S counted in k2: the matrices depend on q = k1/sqrt(k2) alone. unit: k2 [{y}/s2]."""

    a: Array
    unit: float

    def form(self, p: Array) -> Array:
        """Return the matrix of V in zeta from that in scaled zeta."""
        d = np.array([1.0 / sqrt(self.unit), 1.0 / self.unit])
        return p * np.outer(d, d)


def scaled(k1: float, k2: float) -> Scaled:
    """Return the scaled law."""
    return Scaled(np.array([[-0.5 * k1 / sqrt(k2), 0.5], [-1.0, 0.0]]), k2)


def inequality(a: Array, p: Any, tau: Any, square: Any) -> list[list[Any]]:
    """Return the blocks of the matrix that must be negative; square: L^2 tau."""
    return [[a.T @ p + p @ a + square * (C.T @ C), p @ B], [B.T @ p, -tau * np.eye(1)]]


class Feasibility:
    """P for a disturbance rate, compiled once; everything in scaled units."""

    def __init__(self, a: Array) -> None:
        self._a = a
        self._p, self._tau, self._room = lmi.symmetric(2), lmi.unknown(), lmi.unknown()
        self._square = cp.Parameter(nonneg=True)
        matrix = cp.bmat(inequality(a, self._p, self._tau, self._square * self._tau))
        inside = [lmi.below_zero(matrix, self._room), lmi.below_zero(-self._p, self._room)]
        self._problem = cp.Problem(cp.Maximize(self._room), [*inside, cp.trace(self._p) + self._tau == 1.0])

    def find(self, rate: float) -> Array | None:
        """Return P scaled to tau = 1, or None; its eigenvalues confirm it."""
        self._square.value = rate * rate
        if not lmi.solve_again(self._problem) or not self._tau.value > lmi.MARGIN:
            return None
        p = self._p.value / float(self._tau.value)
        matrix = np.block(inequality(self._a, p, 1.0, rate * rate))
        return p if lmi.is_positive(p) and lmi.is_negative(matrix) else None


def largest_rate(k1: float, k2: float) -> Certificate:
    """Certify the largest L: one semidefinite program, as L^2 enters linearly, then from below until confirmed."""
    if k1 <= 0.0 or k2 <= 0.0:
        return inconclusive(RATE_UNIT, "both gains must be positive")
    law = scaled(k1, k2)
    p, square = lmi.symmetric(2), lmi.unknown(nonneg=True)
    matrix = cp.bmat(inequality(law.a, p, 1.0, square))
    if not lmi.solve(cp.Maximize(square), [lmi.below_zero(matrix), lmi.below_zero(-p)]):
        return inconclusive(RATE_UNIT, "the solver found no quadratic Lyapunov function")
    feasibility, best = Feasibility(law.a), sqrt(max(float(square.value), 0.0))
    for share in BACK_OFF:
        rate = (1.0 - share) * best
        solution = feasibility.find(rate)
        if solution is not None:
            why = "every disturbance with |d'| <= L is rejected in finite time (continuous law, no lag)"
            return Certificate(rate * law.unit, RATE_UNIT, True, why, {"P": law.form(solution)})
    return inconclusive(RATE_UNIT, "the eigenvalues did not confirm the solver's matrix")


def run(axis: Loop) -> Certificate:
    """Certify the largest disturbance rate of an axis."""
    term = law(axis.law).super_twisting
    assert term is not None, axis.law
    return largest_rate(getattr(axis.gains, term.k1), getattr(axis.gains, term.k2))


INFO = CertificateInfo(
    name="supertwisting",
    title="largest disturbance rate with finite-time convergence",
    source="Moreno, Osorio, IEEE Trans. Automatic Control 57(4), 2012",
    laws=frozenset(name for name, entry in LAWS.items() if entry.super_twisting is not None),
    run=run,
)
