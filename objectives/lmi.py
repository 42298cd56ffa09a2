"""Common tools of the matrix inequalities: well-scaled coordinates, a solve that never raises, and the check afterwards.

An interior-point solver returns a point inside its tolerance (1e-8), which may lie just outside the inequality. So no answer
counts before its eigenvalues have been looked at in NumPy, with room for the rounding of that look itself.
"""

import warnings
from dataclasses import dataclass
from typing import Any

import cvxpy as cp
import numpy as np
from scipy.linalg import matrix_balance, solve_continuous_lyapunov

Array = np.ndarray

# An inequality counts as strict where the eigenvalue next to zero is beyond this share of the largest one. Rounding in the
# eigenvalues of a symmetric 15 x 15 matrix is some 1e-15 of the largest.
MARGIN = 1e-10


@dataclass(frozen=True)
class Coordinates:
    """Coordinates in which a stable x' = a x contracts evenly.

    They are z = transform x with the time tau = rate t; rate in rad/s.
    """

    transform: Array
    inverse: Array
    rate: float

    def dynamics(self, a: Array) -> Array:
        """Return a in these coordinates and this time."""
        return self.transform @ a @ self.inverse / self.rate

    def original(self, p: Array) -> Array:
        """Return P of the quadratic form x'Px = z'pz of these coordinates."""
        return self.transform.T @ p @ self.transform


def coordinates(a: Array) -> Coordinates:
    """Return coordinates for a Hurwitz matrix: |z| decreases along z' = a z.

    Observer matrices span wo^3; balanced, counted in the geometric mean of the poles, and turned by the Lyapunov matrix of
    the decay rate's half, all that is left is of order one, and so is the P that one looks for.
    """
    balanced, scale = matrix_balance(a, permute=False)
    poles = np.linalg.eigvals(a)
    rate = float(np.exp(np.log(np.abs(poles)).mean(axis=0)))
    slow = 0.5 * float(-poles.real.max(axis=0)) / rate
    root = _root(solve_continuous_lyapunov((balanced / rate + slow * np.eye(len(a))).T, -np.eye(len(a))))
    return Coordinates(root @ np.linalg.inv(scale), scale @ np.linalg.inv(root), rate)


def _root(p: Array) -> Array:
    """Return R with R'R = p; for a p that rounding has made indefinite, on the very edge of stability, no turn at all."""
    try:
        return np.linalg.cholesky(p).T
    except np.linalg.LinAlgError:
        return np.eye(len(p))


def symmetric(n: int) -> Any:
    """Return an unknown symmetric matrix."""
    return cp.Variable((n, n), symmetric=True)


def unknown(nonneg: bool = False) -> Any:
    """Return an unknown number."""
    return cp.Variable(nonneg=nonneg)


def below_zero(matrix: Any, room: Any = 0.0) -> Any:
    """Return the constraint that all eigenvalues are at most -room."""
    return matrix << -room * np.eye(matrix.shape[0])


def is_negative(matrix: Array, margin: float = MARGIN) -> bool:
    """Return True if a symmetric matrix is negative definite with a margin."""
    values = np.linalg.eigvalsh(0.5 * (matrix + matrix.T))
    return bool(values[-1] < -margin * np.abs(values).max(axis=0))


def is_positive(matrix: Array, margin: float = MARGIN) -> bool:
    """Return True if a symmetric matrix is positive definite with a margin."""
    return is_negative(-matrix, margin)


def solve(objective: Any, constraints: list[Any]) -> bool:
    """Solve by Clarabel without a word; whether there is a point to look at, accurate or not."""
    return solve_again(cp.Problem(objective, constraints))


def solve_again(problem: Any) -> bool:
    """Solve a problem whose parameters have changed; it is compiled the first time only."""
    with warnings.catch_warnings():
        for expected in ("Solution may be inaccurate", "geo_mean is being approximated"):
            warnings.filterwarnings("ignore", message=expected, category=UserWarning)
        try:
            problem.solve(solver=cp.CLARABEL)
        except cp.SolverError:
            return False
    return problem.status in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE)
