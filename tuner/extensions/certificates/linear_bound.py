"""Ultimate bound of a linear loop whose slow modes are separated.

It serves loops with slow integral action and fast poles:

    y = sum of c_i x_i + C x,   x_i' = p_i x_i + d_i w,   x' = A x + D w,   |w| <= 1

|x_i| ends within |d_i/p_i|, exactly, and |C x| within sqrt(C Q C') of the ellipsoid with A Q + Q A' + alpha Q + D D'/alpha < 0.
One ellipsoid for all modes decays no faster than the slowest of them and may be a hundred times too large. The smallest sum over
the number of modes apart and over alpha counts. S. Boyd and others, SIAM 1994, section 6.1.3, for the ellipsoid.
"""

from collections.abc import Iterator
from math import sqrt
from typing import Any

import numpy as np
from scipy.linalg import schur, solve_continuous_lyapunov, solve_sylvester

from objectives.lmi import coordinates, is_negative, is_positive
from tuner.extensions.certificates.peak_gain import Disturbed, inequality

Array = np.ndarray

# Decay rates that are tried, as shares of twice that of the slowest pole, and most slow modes that are taken apart.
SHARES, MAX_GRID_DISTANCE = np.linspace(0.02, 0.98, 49), 4
# Room kept in the inequality, as a share of what the disturbance adds to it: the first at which the eigenvalues confirm it.
ROOMS = (1e-6, 1e-4, 1e-2)


def smallest_sum(of: Disturbed) -> float | None:
    """Return the smallest confirmed bound of |c x|, or None.

    The loop is stable and has no sliding term.
    """
    assert of.kappa == 0.0
    sums = [
        of_modes + rest for of_modes, loop in with_modes_apart(of) if (rest := smallest_ellipsoid(loop)) is not None
    ]
    return min(sums, default=None)


def smallest_ellipsoid(of: Disturbed) -> float | None:
    """Return the smallest bound of |c x| by one ellipsoid; eigenvalues confirm it."""
    if not len(of.a):
        return 0.0
    scaled, factor = of.normalized(coordinates(of.a))
    slowest = -2.0 * float(np.linalg.eigvals(scaled.a).real.max(axis=0))
    bounds = [bound for share in SHARES if (bound := bound_at(scaled, float(share) * slowest)) is not None]
    return min(bounds) * factor if bounds else None


def bound_at(of: Disturbed, alpha: float) -> float | None:
    """Return the ellipsoid's bound of |c x| at one decay rate; eigenvalues confirm it."""
    unit = np.eye(len(of.a))
    for room in ROOMS:
        pushed = -(of.d @ of.d.T + room * unit) / alpha
        q = np.asarray(solve_continuous_lyapunov(of.a + 0.5 * alpha * unit, pushed), float)
        if is_positive(q) and is_negative(np.block(inequality(of, q, alpha, 0.0))):
            return sqrt((of.c @ q @ of.c.T).item())
    return None


def with_modes_apart(of: Disturbed) -> Iterator[tuple[float, Disturbed]]:
    """Yield the exact bound of the slowest modes, and the remaining loop.

    The first pair separates no modes; it ends at the first mode that oscillates.
    """
    of_modes = 0.0
    for _ in range(MAX_GRID_DISTANCE + 1):
        yield of_modes, of
        poles = np.linalg.eigvals(of.a) if len(of.a) else np.zeros(0)
        slowest = poles[int(np.abs(poles.real).argmin())] if len(poles) else 1j
        if slowest.imag != 0.0:
            return
        bound, of = _split(of, float(slowest.real))
        of_modes += bound


def _split(of: Disturbed, pole: float) -> tuple[float, Disturbed]:
    """Return a real pole's bound, and the loop without that mode.

    The coordinates do not couple the two.
    """
    edge = pole * (1.0 + 1e-9)

    def is_slow(real: float, imaginary: float = 0.0) -> bool:
        return imaginary == 0.0 and real >= edge

    form: Any = schur(of.a, sort=is_slow)
    triangle, basis, count = form
    n = max(int(count), 1)
    first, coupling, rest = triangle[:n, :n], triangle[:n, n:], triangle[n:, n:]
    turn = solve_sylvester(first, -rest, -coupling)
    c, d = of.c @ basis, basis.T @ of.d
    c_rest, d_first = c[:, n:] + c[:, :n] @ turn, d[:n] - turn @ d[n:]
    bound = float(abs((c[:, :n] @ np.linalg.solve(first, d_first)).item())) if n == 1 else np.inf
    left = Disturbed(rest, of.b[n:], d[n:], of.s[:, n:], c_rest, 0.0)
    return bound, left
