"""Linear algebra of Gaussian processes, compiled: correlations, factors, triangular solutions, the likelihood and its slope.

It is written out because LAPACK and BLAS round differently with the number of their threads, and what a search asks for must
not. The loops run along rows, four rows at a time, which reaches some 5 billion operations a second on one core: a factor of
500 points takes 8 ms.

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

Array = NDArray[np.float64]

OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract", "reassoc", "arcp", "nsz"}}
INLINED = {**OPTIONS, "forceinline": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
# Least square of a pivot: a matrix that rounding has made indefinite is factored as if its pivot were this.
LEAST_PIVOT = 1e-10


def inlined(function: Callable[..., Any]) -> Any:
    """Compile a function into those that call it."""
    return numba.njit(**INLINED)(function)


def compiled(function: Callable[..., Any]) -> Any:
    """Compile a function that is called from Python and keep it."""
    return keep_file(numba.njit(**OPTIONS, nogil=True)(function), Path(function.__code__.co_filename))


@inlined
def scaled_distance(one: Array, other: Array) -> float:
    """Return sqrt(5) times the distance of two points (d,) in length scales."""
    square = 0.0
    for k in range(len(one)):
        square += (one[k] - other[k]) * (one[k] - other[k])
    return math.sqrt(5.0 * square)


@inlined
def matern(a: float) -> float:
    """Return the correlation at a distance a."""
    return (1.0 + a + a * a / 3.0) * math.exp(-a)


@inlined
def take_away(row: Array, rows: Array, factors: Array, count: int, start: int) -> None:
    """Subtract from row (p,), from `start` on, the first `count` of rows (n, p) times factors (n,)."""
    k = 0
    while k + 3 < count:
        a, b, c, d = factors[k], factors[k + 1], factors[k + 2], factors[k + 3]
        for j in range(start, len(row)):
            row[j] -= a * rows[k, j] + b * rows[k + 1, j] + c * rows[k + 2, j] + d * rows[k + 3, j]
        k += 4
    while k < count:
        a = factors[k]
        for j in range(start, len(row)):
            row[j] -= a * rows[k, j]
        k += 1


@inlined
def factor_in_place(matrix: Array) -> None:
    """Overwrite the upper triangle of a symmetric matrix (n, n) by U with U^T U the matrix."""
    n = len(matrix)
    column = np.empty(n)
    for i in range(n):
        for k in range(i):
            column[k] = matrix[k, i]
        take_away(matrix[i], matrix, column, i, i)
        root = math.sqrt(max(matrix[i, i], LEAST_PIVOT))
        matrix[i, i] = root
        for j in range(i + 1, n):
            matrix[i, j] /= root


@inlined
def filled(scaled: Array, noise: float) -> Array:
    """Return the correlations (n, n) of points in length scales (n, d), upper triangle, noise added on the diagonal."""
    n = len(scaled)
    matrix = np.empty((n, n))
    for i in range(n):
        matrix[i, i] = 1.0 + noise
        for j in range(i + 1, n):
            matrix[i, j] = matern(scaled_distance(scaled[i], scaled[j]))
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
        take_away(solution[i], solution, column, i, 0)
        for j in range(solution.shape[1]):
            solution[i, j] /= upper[i, i]
    return solution


@compiled
def correlations(scaled: Array, others: Array) -> Array:
    """Return the correlations (n, p) of points (n, d) with others (p, d), both in length scales."""
    found = np.empty((len(scaled), len(others)))
    for i in range(len(scaled)):
        for j in range(len(others)):
            found[i, j] = matern(scaled_distance(scaled[i], others[j]))
    return found


@compiled
def factored_remainder(scaled: Array, explained: Array, noise: float) -> Array:
    """Return the factor (p, p) of the correlations of points (p, d) less explained^T explained, explained (n, p)."""
    matrix, column = filled(scaled, noise), np.empty(len(explained))
    for i in range(len(matrix)):
        for k in range(len(explained)):
            column[k] = explained[k, i]
        take_away(matrix[i], explained, column, len(explained), i)
    factor_in_place(matrix)
    return matrix


@compiled
def drawn(upper: Array, normals: Array) -> Array:
    """Return normals (s, p) times U (p, p), an upper triangle: rows of covariance U^T U."""
    found = np.zeros(normals.shape)
    for i in range(len(normals)):
        for k in range(len(upper)):
            a = normals[i, k]
            for j in range(k, len(upper)):
                found[i, j] += a * upper[k, j]
    return found


@compiled
def likelihood(points: Array, targets: Array, logs: Array) -> tuple[float, Array]:
    """Return the negative log likelihood of targets (n,) of mean 0 at points (n, d), but for a constant, and its slope (d + 1,).

    logs (d + 1,): logarithms of the inverse length scales and of the noise's share of the variance, which is itself the one
    that fits best (Rasmussen and Williams 2006, equations 5.8 and 5.9).
    """
    n, d = points.shape
    scaled = points * np.exp(logs[:d])
    noise = math.exp(logs[d])
    upper = filled(scaled, noise)
    factor_in_place(upper)
    inverse = inverted(upper)
    weights = np.zeros(n)
    for i in range(n):
        for j in range(n):
            weights[i] += inverse[i, j] * targets[j]
    variance, value = 0.0, 0.0
    for i in range(n):
        variance += targets[i] * weights[i] / n
        value += math.log(upper[i, i])
    slope = np.zeros(d + 1)
    for i in range(n):
        slope[d] += 0.5 * noise * (inverse[i, i] - weights[i] * weights[i] / variance)
        for j in range(i + 1, n):
            a = scaled_distance(scaled[i], scaled[j])
            by_square = (inverse[i, j] - weights[i] * weights[j] / variance) * (1.0 + a) * math.exp(-a) * (5.0 / 3.0)
            for k in range(d):
                slope[k] -= by_square * (scaled[i, k] - scaled[j, k]) * (scaled[i, k] - scaled[j, k])
    return value + 0.5 * n * math.log(variance), slope


@inlined
def inverted(upper: Array) -> Array:
    """Return the inverse (n, n) of U^T U, with U an upper triangle."""
    n = len(upper)
    half = np.zeros((n, n))
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            a = upper[i, k]
            for j in range(k, n):
                half[i, j] -= a * half[k, j]
        half[i, i] = 1.0
        for j in range(i, n):
            half[i, j] /= upper[i, i]
    whole = np.empty((n, n))
    for i in range(n):
        for j in range(i, n):
            total = 0.0
            for k in range(j, n):
                total += half[i, k] * half[j, k]
            whole[i, j] = total
            whole[j, i] = total
    return whole


def is_compiled() -> bool:
    """Return whether this process or an earlier one has compiled this file; else the first model waits some 6 s."""
    return cache.is_compiled(likelihood) and cache.is_compiled(factored_remainder)
