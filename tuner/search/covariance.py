"""Linear algebra of Gaussian processes, compiled: Cholesky factors, triangular solutions, the likelihood and its gradient.

It is written out because LAPACK and BLAS round differently with the number of their threads, and what a search asks for must
not. The loops run along rows, four rows at a time, some columns after the other: a factor of 500 points takes 3.5 ms. Columns
are counted in unsigned numbers: an index that may be negative is counted from the end, and that keeps a loop from SIMD code.

Correlation: Matern 5/2, (1 + a + a^2 / 3) e^{-a} with a = sqrt(5) times the distance in length scales (C. E. Rasmussen,
C. K. I. Williams, "Gaussian Processes for Machine Learning", MIT Press 2006, equation 4.17).
"""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plant.backends import cache
from plant.backends.cache import keep_file
from plant.backends.compiling import inliner, kernel

Array = NDArray[np.float64]

OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract", "reassoc", "arcp", "nsz"}}
inlined, allocating = inliner(OPTIONS), inliner(OPTIONS, allocates=True)
# Distance beyond which correlations no longer fall: e^{-40} is 4e-18. Taylor's series is around half of a 256th of it.
MAX_DISTANCE = 40.0
CENTER = MAX_DISTANCE / 512.0
EXP_CENTER = math.exp(-CENTER)
C2, C3, C4, C5, C6, C7, C8, C9 = [1.0 / math.factorial(k) for k in range(2, 10)]
# Columns that are worked on at a time.
BLOCK_COLUMNS = 64
# The same for a posterior's: 250 rows of them stay in the second cache of a core.
N_COLUMNS = 128
# Least square of a pivot: a matrix that rounding has made indefinite is factored as if its pivot were this.
MIN_PIVOT = 1e-10


def compiled(function: Callable[..., Any]) -> Any:
    """Compile a function that is called from Python and keep it."""
    return keep_file(kernel(OPTIONS)(function), Path(function.__code__.co_filename))


@inlined
def exp_negative(a: float) -> float:
    """Return e^{-a} for a >= 0: to a relative error of 1e-13, in operations that SIMD code has."""
    # Taylor's series around the middle of [0, MAX_DISTANCE / 256], then squared eight times.
    x = CENTER - min(a, MAX_DISTANCE) / 256.0
    power = EXP_CENTER * (
        1.0 + x * (1.0 + x * (C2 + x * (C3 + x * (C4 + x * (C5 + x * (C6 + x * (C7 + x * (C8 + x * C9))))))))
    )
    for _ in range(8):
        power *= power
    return power


@inlined
def fill_distances(row: Array, point: Array, across: Array, start: int) -> None:
    """Set row (p,) from `start` on: sqrt(5) times the distances of a point (d,) from others, across (d, p)."""
    columns = range(np.uintp(start), np.uintp(len(row)))
    for j in columns:
        row[j] = 0.0
    for k in range(len(point)):
        for j in columns:
            row[j] += (point[k] - across[k, j]) * (point[k] - across[k, j])
    for j in columns:
        row[j] = math.sqrt(5.0 * row[j])


@inlined
def fill_correlations(row: Array, point: Array, across: Array, start: int) -> None:
    """Set row (p,) from `start` on: correlations of a point (d,) with others, across (d, p), in length scales."""
    fill_distances(row, point, across, start)
    for j in range(np.uintp(start), np.uintp(len(row))):
        row[j] = (1.0 + row[j] + row[j] * row[j] / 3.0) * exp_negative(row[j])


@inlined
def subtract_product(row: Array, rows: Array, factors: Array, count: int, start: int, end: int) -> None:
    """Subtract factors (n,) times rows (n, p) from row (p,): the first `count` of them, columns `start` to `end`."""
    k, columns = 0, range(np.uintp(start), np.uintp(end))
    while k + 3 < count:
        a, b, c, d = factors[k], factors[k + 1], factors[k + 2], factors[k + 3]
        for j in columns:
            row[j] -= a * rows[k, j] + b * rows[k + 1, j] + c * rows[k + 2, j] + d * rows[k + 3, j]
        k += 4
    while k < count:
        a = factors[k]
        for j in columns:
            row[j] -= a * rows[k, j]
        k += 1


@inlined
def factorize_cholesky(matrix: Array) -> None:
    """Overwrite a matrix (n, n) by its Cholesky factor: U, and U^T below the diagonal.

    Some columns at a time, so that they stay in the nearer caches.
    """
    n = len(matrix)
    for first in range(0, n, BLOCK_COLUMNS):
        end = min(first + BLOCK_COLUMNS, n)
        for i in range(end):
            start = max(i, first)
            subtract_product(matrix[i], matrix, matrix[i], i, start, end)
            if i >= first:
                matrix[i, i] = math.sqrt(max(matrix[i, i], MIN_PIVOT))
            for j in range(max(i + 1, first), end):
                matrix[i, j] /= matrix[i, i]
                matrix[j, i] = matrix[i, j]


@allocating
def correlation_matrix(scaled: Array, noise: float) -> Array:
    """Return the correlation matrix with noise (n, n), upper triangle: of points in length scales (n, d)."""
    n = len(scaled)
    matrix, across = np.empty((n, n)), scaled.T.copy()
    for i in range(n):
        fill_correlations(matrix[i], scaled[i], across, i)
        matrix[i, i] = 1.0 + noise
    return matrix


@compiled
def cholesky_correlation(scaled: Array, noise: float) -> Array:
    """Return the Cholesky factor U (n, n) of the correlation matrix with noise: of points in length scales (n, d)."""
    matrix = correlation_matrix(scaled, noise)
    factorize_cholesky(matrix)
    return matrix


@inlined
def subtract_products(four: Array, rows: Array, factors: Array, count: int) -> None:
    """Subtract factors (4, n) times rows (n, p) from four rows (4, p): the first `count` of them, a multiple of 4.

    Each row is read once for all four.
    """
    for k in range(0, count, 4):
        a, b, c, d = factors[0, k], factors[0, k + 1], factors[0, k + 2], factors[0, k + 3]
        e, f, g, h = factors[1, k], factors[1, k + 1], factors[1, k + 2], factors[1, k + 3]
        m, n, o, p = factors[2, k], factors[2, k + 1], factors[2, k + 2], factors[2, k + 3]
        q, r, s, t = factors[3, k], factors[3, k + 1], factors[3, k + 2], factors[3, k + 3]
        for j in range(np.uintp(four.shape[1])):
            w, x, y, z = rows[k, j], rows[k + 1, j], rows[k + 2, j], rows[k + 3, j]
            four[0, j] -= a * w + b * x + c * y + d * z
            four[1, j] -= e * w + f * x + g * y + h * z
            four[2, j] -= m * w + n * x + o * y + p * z
            four[3, j] -= q * w + r * x + s * y + t * z


@inlined
def substitute(solution: Array, upper: Array) -> None:
    """Overwrite right sides (n, p) by U^-T times them.

    upper (n, n): an upper triangle U that is mirrored below.
    """
    n, p = solution.shape
    for first in range(0, n, 4):
        end = min(first + 4, n)
        if end - first == 4:
            subtract_products(solution[first:end], solution, upper[first:end], first)
        else:
            for i in range(first, end):
                subtract_product(solution[i], solution, upper[i], first, 0, p)
        for i in range(first, end):
            subtract_product(solution[i], solution[first:], upper[i, first:], i - first, 0, p)
            for j in range(p):
                solution[i, j] /= upper[i, i]


@compiled
def solve_triangular(upper: Array, right: Array) -> Array:
    """Return U^-T right (n, p), with U an upper triangle (n, n), mirrored below."""
    solution = right.copy()
    substitute(solution, upper)
    return solution


@inlined
def add_moments(rows: Array, factors: Array, products: Array, squares: Array) -> None:
    """Add factors (n,) times rows (n, p) to products (p,), and their squares to squares (p,)."""
    for i in range(len(rows)):
        for j in range(np.uintp(rows.shape[1])):
            products[j] += factors[i] * rows[i, j]
            squares[j] += rows[i, j] * rows[i, j]


@compiled
def condition(upper: Array, half: Array, scaled: Array, others: Array, keep: bool) -> tuple[Array, Array, Array]:
    """Return a normal distribution at others (p, d), conditioned on points (n, d).

    All points are in length scales; some columns are worked on at a time.
    upper (n, n): mirrored Cholesky factor U of the points' correlation; half (n,): U^-T targets.

    Returns the mean (p,), the explained share of the variance (p,), and U^-T correlations (n, p): (n, 0) unless they are kept.
    """
    n, p = len(scaled), len(others)
    mean, share, explained = np.zeros(p), np.zeros(p), np.empty((n, p if keep else 0))
    room = np.empty(n * min(p, N_COLUMNS))
    for first in range(0, p, N_COLUMNS):
        end = min(first + N_COLUMNS, p)
        part, across = room[: n * (end - first)].reshape(n, end - first), others[first:end].T.copy()
        for i in range(n):
            fill_correlations(part[i], scaled[i], across, 0)
        substitute(part, upper)
        add_moments(part, half, mean[first:end], share[first:end])
        for i in range(n if keep else 0):
            # Not an assignment of the block, which takes numba 4 s to compile.
            for j in range(np.uintp(end - first)):
                explained[i, first + j] = part[i, j]
    return mean, share, explained


@compiled
def cholesky_posterior(scaled: Array, explained: Array, noise: float) -> Array:
    """Return the Cholesky factor (p, p) of a posterior correlation: of points (p, d), less explained^T explained (n, p)."""
    matrix, across, p = correlation_matrix(scaled, noise), explained.T.copy(), len(scaled)
    for first in range(0, p, BLOCK_COLUMNS):
        end = min(first + BLOCK_COLUMNS, p)
        for i in range(end):
            subtract_product(matrix[i], explained, across[i], len(explained), max(i, first), end)
    factorize_cholesky(matrix)
    return matrix


@compiled
def sample_normal(upper: Array, normals: Array) -> Array:
    """Return normals (s, p) times U (p, p), an upper triangle: rows of covariance U^T U."""
    out, p = np.zeros(normals.shape), len(upper)
    for first in range(0, p, BLOCK_COLUMNS):
        end = min(first + BLOCK_COLUMNS, p)
        for i in range(len(normals)):
            # Below its diagonal U holds its mirror image, which does not belong here.
            subtract_product(out[i], upper, normals[i], first, first, end)
            for k in range(first, end):
                for j in range(np.uintp(k), np.uintp(end)):
                    out[i, j] -= normals[i, k] * upper[k, j]
    return -out


@compiled
def likelihood(points: Array, targets: Array, logs: Array) -> tuple[float, Array]:
    """Return the negative log marginal likelihood and its gradient (d + 1,): up to a constant.

    targets (n,): of mean 0, at points (n, d);
    logs (d + 1,): logarithms of the inverse length scales and of the noise's share of the variance, which is itself the one
    that fits best (Rasmussen and Williams 2006, equations 5.8 and 5.9).
    """
    n, d = points.shape
    scaled = points * np.exp(logs[:d])
    across, by_square = scaled.T.copy(), np.empty(n)
    noise = math.exp(logs[d])
    upper = correlation_matrix(scaled, noise)
    factorize_cholesky(upper)
    inverse = invert(upper)
    weights = np.zeros(n)
    for i in range(n):
        weights[i] += inverse[i, i] * targets[i]
        for j in range(np.uintp(i + 1), np.uintp(n)):
            weights[i] += inverse[i, j] * targets[j]
            weights[j] += inverse[i, j] * targets[i]
    variance, value = 0.0, 0.0
    for i in range(n):
        variance += targets[i] * weights[i] / n
        value += math.log(upper[i, i])
    gradient = np.zeros(d + 1)
    for i in range(n):
        gradient[d] += 0.5 * noise * (inverse[i, i] - weights[i] * weights[i] / variance)
        fill_distances(by_square, scaled[i], across, i + 1)
        others = range(np.uintp(i + 1), np.uintp(n))
        for j in others:
            by_square[j] = (1.0 + by_square[j]) * exp_negative(by_square[j]) * (5.0 / 3.0)
            by_square[j] *= inverse[i, j] - weights[i] * weights[j] / variance
        for k in range(d):
            for j in others:
                gradient[k] -= by_square[j] * (scaled[i, k] - across[k, j]) * (scaled[i, k] - across[k, j])
    return value + 0.5 * n * math.log(variance), gradient


@allocating
def invert(upper: Array) -> Array:
    """Return the inverse (n, n) of U^T U: upper triangle, with U an upper triangle (n, n)."""
    n = len(upper)
    half_inverse, inverse = np.zeros((n, n)), np.zeros((n, n))
    for i in range(n - 1, -1, -1):
        subtract_product(half_inverse[i], half_inverse[i + 1 :], upper[i, i + 1 :], n - 1 - i, i + 1, n)
        half_inverse[i, i] = 1.0
        for j in range(np.uintp(i), np.uintp(n)):
            half_inverse[i, j] /= upper[i, i]
    across = half_inverse.T.copy()
    for i in range(n):
        subtract_product(inverse[i], across[i:], half_inverse[i, i:], n - i, i, n)
    return -inverse


def is_compiled() -> bool:
    """Return true where this file was compiled before; the first model waits some 6 s otherwise."""
    return cache.is_compiled(likelihood) and cache.is_compiled(cholesky_posterior)
