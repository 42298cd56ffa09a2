"""Ultimate bound: how far a bounded disturbance can push an axis, observer, rotor lag and sliding term included.

    x' = A x - B phi(S) + D w,   |w| <= 1,   0 <= phi(S)/S <= kappa

An ellipsoid x'Px <= 1 that no such w can leave, and that every flight ends in, exists for a decay alpha > 0 if, with
Q = P^-1 and sigma > 0,

    [[A Q + Q A' + alpha Q,  -sigma B + Q S',  D     ],
     [(.)',                  -2 sigma/kappa,   0     ],
     [(.)',                  0,               -alpha ]] < 0.

Then |C x| ends at most at sqrt(C Q C'). The smallest over alpha is reported: the star norm of a linear loop, which bounds its
peak gain, the L1 norm of its impulse response, from above (by 1.1 to 1.3 times at the default gains). For a law with a sliding
term it holds at every amplitude. S. Boyd, L. El Ghaoui, E. Feron, V. Balakrishnan, Linear Matrix Inequalities in System and
Control Theory, SIAM 1994, sections 6.1.3 and 8.1.

w is the disturbance itself, |f| <= 1 {y}/s2.
"""

from dataclasses import dataclass, replace
from math import sqrt
from typing import Any

import cvxpy as cp
import numpy as np

from objectives import lmi
from objectives.linear_axis.channel_model import MODELLED, Loop, closed_loop, is_stable, sector
from tuner.extensions.certificates.certificate import Certificate, CertificateInfo, inconclusive

Array = np.ndarray

# Unit of y per unit of disturbance.
UNIT = "s2"
# Room kept in the inequality, in scaled units, so that the eigenvalues confirm it; costs about as much of the bound.
ROOM = 1e-6
# The decay rate is searched between 0 and twice that of the loop's slowest pole: rounds of so many points each, then again
# between the neighbours of the best.
ROUNDS, POINTS = 3, 5


@dataclass(frozen=True)
class Disturbed:
    """A loop with a sector nonlinearity and a disturbance.

    x' = a x - b phi(s x) + d w, with the output c x. kappa: sector of phi; b, d columns, s, c rows.
    """

    a: Array
    b: Array
    d: Array
    s: Array
    c: Array
    kappa: float

    def normalized(self, z: lmi.Coordinates) -> tuple["Disturbed", float]:
        """Return the same in other coordinates, and the bound's factor.

        There d and c have length one, b and s equal size.
        """
        b, d = z.transform @ self.b / z.rate, z.transform @ self.d / z.rate
        s, c = self.s @ z.inverse, self.c @ z.inverse
        sizes = [float(np.linalg.norm(part)) for part in (b, d, s, c)]
        b_size, d_size, s_size, c_size = (size if size > 0.0 else 1.0 for size in sizes)
        scaled = replace(
            self,
            a=z.dynamics(self.a),
            b=b / b_size,
            d=d / d_size,
            s=s / s_size,
            c=c / c_size,
            kappa=self.kappa * b_size * s_size,
        )
        return scaled, d_size * c_size


def inequality(of: Disturbed, q: Any, alpha: Any, sigma: Any) -> list[list[Any]]:
    """Return the blocks of the matrix that must be negative; without phi there is no middle row."""
    n, corner = len(of.a), -alpha * np.eye(1)
    decay = of.a @ q + q @ of.a.T + alpha * q
    if of.kappa == 0.0:
        return [[decay, of.d], [of.d.T, corner]]
    cross, zero = q @ of.s.T - sigma * of.b, np.zeros((1, 1))
    assert cross.shape == (n, 1)
    return [[decay, cross, of.d], [cross.T, (-2.0 / of.kappa) * sigma * np.eye(1), zero], [of.d.T, zero, corner]]


class Ellipsoids:
    """The smallest ellipsoid along the output for a given decay; compiled once."""

    def __init__(self, of: Disturbed) -> None:
        self._of = of
        self._q, self._sigma = lmi.symmetric(len(of.a)), lmi.unknown(nonneg=True)
        self._alpha = cp.Parameter(pos=True)
        matrix = cp.bmat(inequality(of, self._q, self._alpha, self._sigma))
        self._problem = cp.Problem(cp.Minimize(cp.sum(of.c @ self._q @ of.c.T)), [lmi.below_zero(matrix, ROOM)])

    def find(self, alpha: float) -> tuple[float, Array] | None:
        """Return the bound of |c x| and Q, or None; eigenvalues confirm them."""
        self._alpha.value = alpha
        if not lmi.solve_again(self._problem):
            return None
        q, sigma, of = self._q.value, float(self._sigma.value or 0.0), self._of
        if not (lmi.is_positive(q) and lmi.is_negative(np.block(inequality(of, q, alpha, sigma)))):
            return None
        return sqrt((of.c @ q @ of.c.T).item()), q


def peak_bound(of: Disturbed) -> tuple[float, Array] | None:
    """Return the smallest bound of |c x| and its P, or None.

    It is the smallest over the decay rates; P is that of its ellipsoid.
    """
    z = lmi.coordinates(of.a)
    scaled, factor = of.normalized(z)
    ellipsoids = Ellipsoids(scaled)
    low, high = 0.0, -2.0 * float(np.linalg.eigvals(scaled.a).real.max(axis=0))
    best: tuple[float, Array] | None = None
    for _ in range(ROUNDS):
        rates = np.linspace(low, high, POINTS + 2)
        solutions = [ellipsoids.find(float(rate)) for rate in rates[1:-1]]
        bounds = np.array([np.inf if entry is None else entry[0] for entry in solutions])
        k = int(bounds.argmin(axis=0))
        if solutions[k] is None:
            break
        best = min(filter(None, (best, solutions[k])), key=lambda entry: entry[0])
        low, high = rates[k], rates[k + 2]
    if best is None:
        return None
    size = float(np.linalg.norm(z.transform @ of.d / z.rate))
    return best[0] * factor, z.original(np.linalg.inv(best[1])) / size**2


def disturbed(axis: Loop) -> Disturbed:
    """Return the axis with its disturbance, and y as output."""
    loop = closed_loop(axis)
    a, d, c = loop.channel("disturbance", "value")
    _, b, s = loop.channel("power", "sliding")
    return Disturbed(a, -b, d, s, c, sector(axis))


def run(axis: Loop) -> Certificate:
    """Certify where |y| of an axis ends, per unit of disturbance."""
    of = disturbed(axis)
    if not is_stable(of.a):
        return inconclusive(UNIT, "the loop at small amplitude is not stable")
    solution = peak_bound(of)
    if solution is None:
        return inconclusive(UNIT, "no ellipsoid was found that holds for every amplitude")
    bound, p = solution
    return Certificate(
        bound, UNIT, True, "|value| ends within this times the size of the disturbance, whatever that does", {"P": p}
    )


INFO = CertificateInfo(
    name="peak_gain",
    title="ultimate bound under the worst disturbance of size one",
    source="Boyd, El Ghaoui, Feron, Balakrishnan, SIAM 1994, section 6.1.3",
    laws=MODELLED,
    run=run,
)
