"""Absolute stability of the hybrid: how strong the sliding term may be before stability at every amplitude is unproved.

    x' = A x - B phi(S),   0 <= phi(S)/S <= kappa

V = x'Px + 2 eta int_0^S phi falls along every flight of the unsaturated axis if, with rho = 1/kappa,

    [[A'P + PA, -PB + S' + eta A'S'], [(.)', -2 rho - 2 eta S B]] < 0,   P > 0,   eta >= 0.

eta = 0 is the circle criterion, 1 + kappa Re G(jw) > 0; eta > 0 is Popov's, less conservative because phi does not change with
time. k2 stands in A, so A is the loop at small amplitude and must be stable; phi is k1 |S|^(1/2) sat(S/delta), kappa =
k1/sqrt(delta). S. Boyd et al., Linear Matrix Inequalities in System and Control Theory, SIAM 1994, section 8.1; H. K. Khalil,
Nonlinear Systems, 3rd ed., Prentice Hall 2002, section 7.1.
"""

from typing import Any

import cvxpy as cp
import numpy as np

from objectives import lmi
from objectives.linear_axis.channel_model import MODELLED, WITH_SECTOR, Loop, closed_loop, is_stable, sector
from tuner.extensions.certificates.certificate import Certificate, CertificateInfo, inconclusive

Array = np.ndarray

# 1/kappa is taken larger than the optimum by these shares until the eigenvalues agree.
BACK_OFF = (1e-5, 1e-4, 1e-3, 1e-2)
# In scaled units, where the gain of the linear part is of order one: what counts as a sector without end.
MIN_RHO = 1e-6


class AbsoluteStability:
    """Matrix inequality of absolute stability for one linear part.

    x' = a x - b phi and S = s x, in scaled units.
    """

    def __init__(self, a: Array, b: Array, s: Array, popov: bool) -> None:
        self._a, self._b, self._s = a, b, s
        self._p, self._eta = lmi.symmetric(len(a)), lmi.unknown(nonneg=True)
        self._criterion = [] if popov else [self._eta == 0.0]

    def blocks(self, p: Any, eta: Any, rho: Any) -> list[list[Any]]:
        """Return the blocks of the matrix that must be negative."""
        a, b, s = self._a, self._b, self._s
        cross = -p @ b + s.T + eta * (a.T @ s.T)
        return [[a.T @ p + p @ a, cross], [cross.T, -2.0 * rho * np.eye(1) - 2.0 * eta * (s @ b)]]

    def smallest_rho(self) -> float | None:
        """Return the infimum of 1/kappa, as the solver has it."""
        rho = lmi.unknown()
        matrix = cp.bmat(self.blocks(self._p, self._eta, rho))
        solved = lmi.solve(cp.Minimize(rho), [lmi.below_zero(matrix), lmi.below_zero(-self._p), *self._criterion])
        return float(rho.value) if solved else None

    def find(self, rho: float) -> tuple[Array, float] | None:
        """Return P and eta for 1/kappa = rho, or None; eigenvalues confirm them."""
        room = lmi.unknown()
        matrix = cp.bmat(self.blocks(self._p, self._eta, rho))
        inside = [lmi.below_zero(matrix, room), lmi.below_zero(-self._p, room), room <= 1.0]
        if not lmi.solve(cp.Maximize(room), [*inside, *self._criterion]):
            return None
        p, eta = self._p.value, max(float(self._eta.value), 0.0)
        return (p, eta) if lmi.is_positive(p) and lmi.is_negative(np.block(self.blocks(p, eta, rho))) else None


def largest_sector(a: Array, b: Array, s: Array, popov: bool) -> tuple[float, Array, float] | None:
    """Return the largest kappa with its P and eta, or None.

    The system x' = a x - b phi(s x) is Hurwitz.
    """
    z = lmi.coordinates(a)
    b_z, s_z = z.transform @ b / z.rate, s @ z.inverse
    b_size, s_size = float(np.linalg.norm(b_z)), float(np.linalg.norm(s_z))
    part = AbsoluteStability(z.dynamics(a), b_z / b_size, s_z / s_size, popov)
    rho = part.smallest_rho()
    if rho is None:
        return None
    for share in BACK_OFF:
        tried = max((1.0 + share) * rho, MIN_RHO)
        solution = part.find(tried)
        if solution is not None:
            p, eta = solution
            # V per unit of phi S: both are scaled, and so is the time that V' is taken in.
            return 1.0 / (tried * b_size * s_size), z.original(p) * s_size / (b_size * z.rate), eta / z.rate
    return None


def run(axis: Loop, popov: bool = True) -> Certificate:
    """Certify the largest k1/sqrt(delta) of an axis with a power-rate term.

    All other gains are as given.
    data: "given", the axis' own k1/sqrt(delta), and "kept", whether it is inside.
    """
    loop = closed_loop(axis)
    a, b, s = loop.channel("power", "sliding")
    given = sector(axis)
    if not is_stable(a):
        return inconclusive(
            "s^-1", "the loop at small amplitude, with k2 alone, is not stable", given=given, kept=False
        )
    solution = largest_sector(a, -b, s, popov)
    if solution is None:
        return inconclusive("s^-1", "the eigenvalues did not confirm any sector", given=given, kept=False)
    kappa, p, eta = solution
    criterion = "Popov" if popov else "circle"
    return Certificate(
        kappa,
        "s^-1",
        True,
        f"stable at every amplitude while k1/sqrt(delta) is at most this ({criterion} criterion)",
        {"P": p, "eta": eta, "given": given, "kept": given <= kappa},
    )


INFO = CertificateInfo(
    name="circle_criterion",
    title="largest k1/sqrt(delta) with stability at every amplitude",
    source="Boyd, El Ghaoui, Feron, Balakrishnan, SIAM 1994, section 8.1; Khalil, Nonlinear Systems, 3rd ed., section 7.1",
    laws=WITH_SECTOR & MODELLED,
    run=run,
)
