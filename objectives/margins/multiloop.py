"""Multi-loop disk margin: disks of factors in all plant inputs at once.

    alpha >= 1 / max_w mu(T(e^jwh) + c I),   mu <= min over D = diag(d) > 0 of sigma_max(D M D^-1)

with the structured singular value mu for diagonal perturbations (J. Doyle, IEE Proc. D 129(6), 1982; for up to three channels the
bound is mu itself). ln sigma_max(D M D^-1) is convex in ln d. A first D makes rows and columns equally long (E. E. Osborne,
J. ACM 7(4), 1960); where that leaves the highest bound it is lowered along the gradient, which the singular vectors give:
d ln sigma/d ln d_i = |u_i|^2 - |v_i|^2. Every D gives a valid bound, so the margin is never too large.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from objectives.margins.classical import MarginAt
from objectives.margins.frequency import Modes

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

SWEEPS, DESCENT = 10, 30
# Gradient at which a bound is at its least, and the share of the promised fall that a step must bring.
FLAT, ARMIJO = 1e-9, 1e-2
# Frequencies at which the highest bound is lowered, and how often the interval about the last is divided into how many points.
LOWERED, ZOOMS, POINTS = 4, 4, 5


def balanced(m: Complex) -> Array:
    """Return ln d (..., k) after sweeps of balancing.

    They make the off-diagonal row and column of each channel equally long.
    """
    k = m.shape[-1]
    square = np.abs(m) ** 2 * (1.0 - np.eye(k))
    log_d = np.zeros(m.shape[:-1])
    for sweep in range(SWEEPS * k):
        i = sweep % k
        distance = 2.0 * (log_d[..., i : i + 1] - log_d)
        row = np.sum(square[..., i, :] * np.exp(distance), axis=-1)
        column = np.sum(square[..., :, i] * np.exp(-distance), axis=-1)
        both = (row > 0.0) & (column > 0.0)
        log_d[..., i] += 0.25 * np.log(np.where(both, column, 1.0) / np.where(both, row, 1.0))
    return log_d


def scaled_norm(m: Complex, log_d: Array) -> tuple[Array, Array]:
    """Return the largest singular value (...) of D M D^-1 and a gradient.

    The gradient (..., k) is that of the value's logarithm by ln d.
    """
    u, s, v = np.linalg.svd(m * np.exp(log_d[..., :, None] - log_d[..., None, :]))
    return s[..., 0], np.abs(u[..., :, 0]) ** 2 - np.abs(v[..., 0, :]) ** 2


def mu_upper(m: Complex) -> Array:
    """Return an upper bound (...) of mu of matrices (..., k, k).

    mu is the structured singular value for diagonal complex perturbations.
    """
    log_d = balanced(m)
    value, slope = scaled_norm(m, log_d)
    step = np.ones(value.shape)
    for _ in range(DESCENT):
        # Each matrix ends its own descent, so that its bound does not depend on the others.
        steep = np.max(np.abs(slope), axis=-1) >= FLAT
        if not steep.any():
            break
        trial = log_d - step[..., None] * slope
        lower, its_slope = scaled_norm(m, trial)
        promised = step * np.sum(slope**2, axis=-1)
        better = steep & (lower < value * np.exp(-ARMIJO * promised))
        value = np.where(better, lower, value)
        log_d, slope = (np.where(better[..., None], new, old) for new, old in ((trial, log_d), (its_slope, slope)))
        step = np.where(better, 1.6, 0.4) * step
    return value


def multiloop_margin(modes: Modes, channels: Sequence[int], grid: Array, h: float, center: float) -> MarginAt:
    """Return the disk margin alpha (n,) in some channels at once.

    Its frequency is in rad/s; the channels are the first inputs and outputs of the modes.
    """

    def matrices(w: Array) -> Complex:
        """T + c I (n, f, k, k) at frequencies (n, f)."""
        return modes.response(np.exp(1j * w * h), channels, channels) + center * np.eye(len(channels))

    rows, last = np.arange(len(modes.size)), grid.shape[1] - 1
    w = np.broadcast_to(grid[0], (len(rows), last + 1))
    m = matrices(w)
    bound, _ = scaled_norm(m, balanced(m))
    for _ in range(LOWERED):
        top = np.argmax(bound, axis=-1)
        bound[rows, top] = mu_upper(m[rows, top])
    top = np.argmax(bound, axis=-1)
    low, high = grid[0, np.maximum(top - 1, 0)], grid[0, np.minimum(top + 1, last)]
    peak, at = bound[rows, top], grid[0, top]
    for _ in range(ZOOMS):
        w = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, POINTS)
        values = mu_upper(matrices(w))
        best = np.argmax(values, axis=-1)
        higher = values[rows, best] > peak
        peak, at = np.where(higher, values[rows, best], peak), np.where(higher, w[rows, best], at)
        low, high = w[rows, np.maximum(best - 1, 0)], w[rows, np.minimum(best + 1, POINTS - 1)]
    return MarginAt(1.0 / peak, at)
