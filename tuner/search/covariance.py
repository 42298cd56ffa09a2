"""Linear algebra of Gaussian processes, compiled: correlations, factors, triangular solutions, the likelihood and its slope.

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

import numba
import numpy as np
from numpy.typing import NDArray

from plant.backends import cache
from plant.backends.cache import keep_file
from plant.backends.compiling import inliner

Array = NDArray[np.float64]

OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract", "reassoc", "arcp", "nsz"}}
inlined = inliner(OPTIONS)
# Distance beyond which correlations no longer fall: e^{-40} is 4e-18. Taylor's series stands around half of a 256th of it.
FURTHEST = 40.0
CENTRE = FURTHEST / 512.0
AT_CENTRE = math.exp(-CENTRE)
C2, C3, C4, C5, C6, C7, C8, C9 = [1.0 / math.factorial(k) for k in range(2, 10)]
# Columns that are worked on at a time.
COLUMNS = 64
# Least square of a pivot: a matrix that rounding has made indefinite is factored as if its pivot were this.
LEAST_PIVOT = 1e-10


def compiled(function: Callable[..., Any]) -> Any:
    """Compile a function that is called from Python and keep it."""
    return keep_file(numba.njit(**OPTIONS, nogil=True)(function), Path(function.__code__.co_filename))


@inlined
def decay(a: float) -> float:
    """Return e^{-a} for a >= 0 but for 1e-13 of it, in operations that a loop over many a does side by side."""
    # Taylor's series around the middle of [0, FURTHEST / 256], then squared eight times.
    x = CENTRE - min(a, FURTHEST) / 256.0
    power = AT_CENTRE * (
        1.0 + x * (1.0 + x * (C2 + x * (C3 + x * (C4 + x * (C5 + x * (C6 + x * (C7 + x * (C8 + x * C9))))))))
    )
    for _ in range(8):
        power *= power
    return power


@inlined
def fill_distances(row: Array, point: Array, across: Array, start: int) -> None:
    """Set row (p,), from `start` on, to sqrt(5) times the distances of a point (d,) from others, across (d, p)."""
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
    """Set row (p,), from `start` on, to the correlations of a point (d,) with others, across (d, p), in length scales."""
    fill_distances(row, point, across, start)
    for j in range(np.uintp(start), np.uintp(len(row))):
        row[j] = (1.0 + row[j] + row[j] * row[j] / 3.0) * decay(row[j])


@inlined
def take_away(row: Array, rows: Array, factors: Array, count: int, start: int, end: int) -> None:
    """Subtract from row (p,), from `start` to `end`, the first `count` of rows (n, p) times factors (n,)."""
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
def factor_in_place(matrix: Array) -> None:
    """Overwrite a symmetric matrix (n, n), of which the upper triangle counts, by U with U^T U the matrix, and its mirror image.

    Some columns at a time, so that what is taken from them stays in the nearer caches.
    """
    n = len(matrix)
    for first in range(0, n, COLUMNS):
        end = min(first + COLUMNS, n)
        for i in range(end):
            start = max(i, first)
            take_away(matrix[i], matrix, matrix[i], i, start, end)
            if i >= first:
                matrix[i, i] = math.sqrt(max(matrix[i, i], LEAST_PIVOT))
            for j in range(max(i + 1, first), end):
                matrix[i, j] /= matrix[i, i]
                matrix[j, i] = matrix[i, j]


@inlined
def filled(scaled: Array, noise: float) -> Array:
    """Return the correlations (n, n) of points in length scales (n, d), upper triangle, noise added on the diagonal."""
    n = len(scaled)
    matrix, across = np.empty((n, n)), scaled.T.copy()
    for i in range(n):
        fill_correlations(matrix[i], scaled[i], across, i)
        matrix[i, i] = 1.0 + noise
    return matrix


@compiled
def factored_correlations(scaled: Array, noise: float) -> Array:
    """Return U (n, n), upper triangle, with U^T U the correlations of points in length scales (n, d) and noise."""
    matrix = filled(scaled, noise)
    factor_in_place(matrix)
    return matrix


@compiled
def half_solved(upper: Array, right: Array) -> Array:
    """Return U^-T right (n, p), with U an upper triangle (n, n)."""
    n = len(upper)
    solution, column = right.copy(), np.empty(n)
    for i in range(n):
        for k in range(i):
            column[k] = upper[k, i]
        take_away(solution[i], solution, column, i, 0, solution.shape[1])
        for j in range(solution.shape[1]):
            solution[i, j] /= upper[i, i]
    return solution


@compiled
def correlations(scaled: Array, others: Array) -> Array:
    """Return the correlations (n, p) of points (n, d) with others (p, d), both in length scales."""
    found, across = np.empty((len(scaled), len(others))), others.T.copy()
    for i in range(len(scaled)):
        fill_correlations(found[i], scaled[i], across, 0)
    return found


@compiled
def factored_remainder(scaled: Array, explained: Array, noise: float) -> Array:
    """Return the factor (p, p) of the correlations of points (p, d) less explained^T explained, explained (n, p)."""
    matrix, across, p = filled(scaled, noise), explained.T.copy(), len(scaled)
    for first in range(0, p, COLUMNS):
        end = min(first + COLUMNS, p)
        for i in range(end):
            take_away(matrix[i], explained, across[i], len(explained), max(i, first), end)
    factor_in_place(matrix)
    return matrix


@compiled
def drawn(upper: Array, normals: Array) -> Array:
    """Return normals (s, p) times U (p, p), an upper triangle: rows of covariance U^T U."""
    found, p = np.zeros(normals.shape), len(upper)
    for first in range(0, p, COLUMNS):
        end = min(first + COLUMNS, p)
        for i in range(len(normals)):
            # Below its diagonal U holds its mirror image, which does not belong here.
            take_away(found[i], upper, normals[i], first, first, end)
            for k in range(first, end):
                for j in range(np.uintp(k), np.uintp(end)):
                    found[i, j] -= normals[i, k] * upper[k, j]
    return -found


@compiled
def likelihood(points: Array, targets: Array, logs: Array) -> tuple[float, Array]:
    """Return the negative log likelihood of targets (n,) of mean 0 at points (n, d), but for a constant, and its slope (d + 1,).

    logs (d + 1,): logarithms of the inverse length scales and of the noise's share of the variance, which is itself the one
    that fits best (Rasmussen and Williams 2006, equations 5.8 and 5.9).
    """
    n, d = points.shape
    scaled = points * np.exp(logs[:d])
    across, by_square = scaled.T.copy(), np.empty(n)
    noise = math.exp(logs[d])
    upper = filled(scaled, noise)
    factor_in_place(upper)
    inverse = inverted(upper)
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
    slope = np.zeros(d + 1)
    for i in range(n):
        slope[d] += 0.5 * noise * (inverse[i, i] - weights[i] * weights[i] / variance)
        fill_distances(by_square, scaled[i], across, i + 1)
        others = range(np.uintp(i + 1), np.uintp(n))
        for j in others:
            by_square[j] = (1.0 + by_square[j]) * decay(by_square[j]) * (5.0 / 3.0)
            by_square[j] *= inverse[i, j] - weights[i] * weights[j] / variance
        for k in range(d):
            for j in others:
                slope[k] -= by_square[j] * (scaled[i, k] - across[k, j]) * (scaled[i, k] - across[k, j])
    return value + 0.5 * n * math.log(variance), slope


@inlined
def inverted(upper: Array) -> Array:
    """Return the inverse (n, n), upper triangle, of U^T U, with U an upper triangle (n, n)."""
    n = len(upper)
    half, whole = np.zeros((n, n)), np.zeros((n, n))
    for i in range(n - 1, -1, -1):
        take_away(half[i], half[i + 1 :], upper[i, i + 1 :], n - 1 - i, i + 1, n)
        half[i, i] = 1.0
        for j in range(np.uintp(i), np.uintp(n)):
            half[i, j] /= upper[i, i]
    across = half.T.copy()
    for i in range(n):
        take_away(whole[i], across[i:], half[i, i:], n - i, i, n)
    return -whole


def is_compiled() -> bool:
    """Return whether this process or an earlier one has compiled this file; else the first model waits some 6 s."""
    return cache.is_compiled(likelihood) and cache.is_compiled(factored_remainder)
