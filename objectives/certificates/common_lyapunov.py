"""One quadratic Lyapunov function for a whole box of vehicles: mass and inertia anywhere within +-x %, varying as they like.

    A_i'P + P A_i + 2 sigma P < 0,   P > 0   at every corner i of the box

A depends affinely on 1/mass and 1/inertia (and 1/lag), so what holds at the corners holds inside, and x'Px falls at least as
exp(-2 sigma t) even while the numbers change in flight. Sufficient only: vehicles that stay as they are may be stable far
beyond. S. Boyd, L. El Ghaoui, E. Feron, V. Balakrishnan, Linear Matrix Inequalities in System and Control Theory, SIAM 1994,
section 5.1. The law is taken at small amplitude (the hybrid with k2 alone); thrust varies as 1/mass and 1/inertia do.
"""

from collections.abc import Sequence
from itertools import product
from typing import Any

import cvxpy as cp
import numpy as np

from objectives.certificates.certificate import Certificate, CertificateInfo, inconclusive
from objectives.certificates.channel_model import MODELLED, Factors, Loop, closed_loop, is_stable
from objectives.certificates.lmi import (
    below_zero,
    coordinates,
    is_negative,
    is_positive,
    solve_again,
    symmetric,
    unknown,
)

Array = np.ndarray

VARIED = ("mass", "inertia")
# The largest spread asked about: a tenth to nearly twice the nominal number.
LARGEST_SPREAD = 0.9
BISECTIONS = 10


def corners(axis: Loop, spread: float, varied: Sequence[str] = VARIED) -> list[Array]:
    """Return A at the corners of the box of +-spread; varied: "mass", "inertia", "lag". Corners that agree come once."""
    matrices: list[Array] = []
    for signs in product((-1.0, 1.0), repeat=len(varied)):
        factors = Factors(**{name: 1.0 + sign * spread for name, sign in zip(varied, signs, strict=True)})
        a = closed_loop(axis, factors).a
        if not any(np.array_equal(a, other) for other in matrices):
            matrices.append(a)
    return matrices


class Corners:
    """The inequalities for some matrices, in coordinates that suit a Hurwitz matrix amid them; compiled once."""

    def __init__(self, matrices: Sequence[Array], centre: Array) -> None:
        self._z = coordinates(centre)
        self._a = [self._z.dynamics(a) for a in matrices]
        self._p, self._decay, room = symmetric(len(centre)), cp.Parameter(nonneg=True), unknown()
        falling = [below_zero(self._rate(a, self._p, self._decay), room) for a in self._a]
        inside: list[Any] = [*falling, below_zero(-self._p, room), cp.trace(self._p) == len(centre), room <= 1.0]
        self._problem = cp.Problem(cp.Maximize(room), inside)

    def find(self, decay: float) -> Array | None:
        """Return P in the original coordinates for a decay [rad/s], confirmed by eigenvalues, or None."""
        scaled = decay / self._z.rate
        self._decay.value = scaled
        if not solve_again(self._problem):
            return None
        p = self._p.value
        falling = all(is_negative(self._rate(a, p, scaled)) for a in self._a)
        return self._z.original(p) if falling and is_positive(p) else None

    @staticmethod
    def _rate(a: Array, p: Any, decay: Any) -> Any:
        return a.T @ p + p @ a + 2.0 * decay * p


def common_matrix(matrices: Sequence[Array], decay: float = 0.0, centre: Array | None = None) -> Array | None:
    """Return P of one Lyapunov function for all matrices, or None; centre: a Hurwitz matrix amid them."""
    if not all(is_stable(a + decay * np.eye(len(a))) for a in matrices):
        return None
    return Corners(matrices, matrices[0] if centre is None else centre).find(decay)


def fastest_decay(axis: Loop, spread: float, varied: Sequence[str] = VARIED) -> Certificate:
    """Certify the largest decay rate [rad/s] that all vehicles of the box share, by bisection."""
    matrices = corners(axis, spread, varied)
    slowest = min(-float(np.linalg.eigvals(a).real.max(axis=0)) for a in matrices)
    if slowest <= 0.0:
        return inconclusive("rad/s", f"a vehicle of the +-{spread:.0%} box is not stable")
    box = Corners(matrices, closed_loop(axis).a)
    solution, low, high = box.find(0.0), 0.0, slowest
    for _ in range(BISECTIONS if solution is not None else 0):
        middle = 0.5 * (low + high)
        trial = box.find(middle)
        solution, low, high = (solution, low, middle) if trial is None else (trial, middle, high)
    if solution is None:
        return inconclusive("rad/s", f"no common quadratic Lyapunov function over the +-{spread:.0%} box")
    return Certificate(
        low, "rad/s", True, f"every vehicle of the +-{spread:.0%} box decays at least this fast", {"P": solution}
    )


def largest_spread(axis: Loop, decay: float = 0.0, varied: Sequence[str] = VARIED) -> Certificate:
    """Certify the largest +-spread [1] of the varied numbers with a common decay [rad/s], by bisection."""
    centre = closed_loop(axis).a
    solution = common_matrix([centre], decay)
    if solution is None:
        return inconclusive("1", f"the nominal vehicle does not decay at {decay:g} rad/s")
    low, high = 0.0, LARGEST_SPREAD
    for k in range(BISECTIONS):
        # The end of the range first: where it is certified there is nothing left to search.
        middle = high if k == 0 else 0.5 * (low + high)
        trial = common_matrix(corners(axis, middle, varied), decay, centre)
        solution, low, high = (solution, low, middle) if trial is None else (trial, middle, high)
        if low == high:
            break
    why = f"one Lyapunov function holds for every vehicle within this share of the nominal {' and '.join(varied)}"
    return Certificate(low, "1", True, why, {"P": solution})


def run(axis: Loop, decay: float = 0.0, varied: Sequence[str] = VARIED) -> Certificate:
    """Certify the largest spread of mass and inertia of an axis."""
    return largest_spread(axis, decay, varied)


INFO = CertificateInfo(
    name="common_lyapunov",
    title="largest spread of mass and inertia with one Lyapunov function",
    source="Boyd, El Ghaoui, Feron, Balakrishnan, SIAM 1994, section 5.1",
    laws=MODELLED,
    run=run,
)
