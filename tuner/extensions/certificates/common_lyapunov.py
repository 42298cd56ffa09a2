"""One quadratic Lyapunov function for a whole box of vehicles: mass and inertia anywhere within +-x %, varying as they like.

    A_i'P + P A_i < 0,   P > 0   at every corner i of the box

A depends affinely on 1/mass and 1/inertia (and 1/lag), so what holds at the corners holds inside, and x'Px falls even while
the numbers change in flight. Sufficient only: vehicles that stay as they are may be stable far beyond. S. Boyd, L. El Ghaoui,
E. Feron, V. Balakrishnan, Linear Matrix Inequalities in System and Control Theory, SIAM 1994, section 5.1. The law is taken at
small amplitude (the hybrid with k2 alone); thrust varies as 1/mass and 1/inertia do.
"""

from collections.abc import Sequence
from itertools import product

import cvxpy as cp
import numpy as np

from objectives import lmi
from objectives.linear_axis.channel_model import MODELLED, Factors, Loop, closed_loop, is_stable
from tuner.extensions.certificates.certificate import Certificate, CertificateInfo, inconclusive

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


def common_matrix(matrices: Sequence[Array], center: Array | None = None) -> Array | None:
    """Return P of one Lyapunov function for all matrices, confirmed by eigenvalues; center: a Hurwitz matrix amid them."""
    if not all(map(is_stable, matrices)):
        return None
    z = lmi.coordinates(matrices[0] if center is None else center)
    scaled, p, room = [z.dynamics(a) for a in matrices], lmi.symmetric(len(matrices[0])), lmi.unknown()
    falling = [lmi.below_zero(a.T @ p + p @ a, room) for a in scaled]
    inside = [*falling, lmi.below_zero(-p, room), cp.trace(p) == len(matrices[0]), room <= 1.0]
    if not lmi.solve(cp.Maximize(room), inside):
        return None
    answer = p.value
    is_confirmed = lmi.is_positive(answer) and all(lmi.is_negative(a.T @ answer + answer @ a) for a in scaled)
    return z.original(answer) if is_confirmed else None


def run(axis: Loop, varied: Sequence[str] = VARIED) -> Certificate:
    """Certify the largest +-spread [1] of the varied numbers, by bisection."""
    center = closed_loop(axis).a
    solution = common_matrix([center])
    if solution is None:
        return inconclusive("1", "the nominal vehicle does not decay at 0 rad/s")
    low, high = 0.0, LARGEST_SPREAD
    for k in range(BISECTIONS):
        # The end of the range first: where it is certified there is nothing left to search.
        middle = high if k == 0 else 0.5 * (low + high)
        trial = common_matrix(corners(axis, middle, varied), center)
        solution, low, high = (solution, low, middle) if trial is None else (trial, middle, high)
        if low == high:
            break
    why = f"one Lyapunov function holds for every vehicle within this share of the nominal {' and '.join(varied)}"
    return Certificate(low, "1", True, why, {"P": solution})


INFO = CertificateInfo(
    name="common_lyapunov",
    title="largest spread of mass and inertia with one Lyapunov function",
    source="Boyd, El Ghaoui, Feron, Balakrishnan, SIAM 1994, section 5.1",
    laws=MODELLED,
    run=run,
)
