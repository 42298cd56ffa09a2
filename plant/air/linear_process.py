"""Stationary Gaussian process of a linear filter driven by white noise, sampled exactly at any step.

    dx = A x dt + b dW,    y = C x,    A lower triangular with negative diagonal (a cascade of lags)

The samples have the distribution of the continuous process at the instants k dt: variance, autocovariance and, below
the Nyquist frequency, spectrum do not depend on dt. Use it for every stationary disturbance with a rational spectrum.

    x[k+1] = A_d x[k] + F n[k],    A_d = exp(A dt),    F F' = Q = int_0^dt exp(A s) b b' exp(A s)' ds
    x[0] = S n[0],                 S S' = P,           A P + P A' + b b' = 0

Source: Van Loan, "Computing integrals involving the matrix exponential", IEEE Trans. Automatic Control 23(3), 1978, for
what Q is. Its block exponential holds exp(-A dt), which overflows where dt is hundreds of times the shortest lag, and Q
itself loses the small pivots of a cascade (they shrink like dt^3 and dt^5) before they can be factored. Here F is found
without forming Q: the Gauss-Legendre sum of the integral over a short step is a product M M', whose QR gives F, and the
step is then doubled.
"""

from collections.abc import Callable
from functools import cache
from math import ceil, log2
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# On a step of at most one shortest lag the integrand varies like exp(-2 s), s <= 1: 12 nodes integrate its series up to
# the power 23, whose next term is 2^24 / 24! = 3e-17.
_NODES = 12


class LinearProcess(NamedTuple):
    """A continuous process: a (n, n) [1/s] lower triangular, b (n,) for white noise of unit intensity, c (m, n)."""

    a: Array
    b: Array
    c: Array


class SampledProcess(NamedTuple):
    """The same process at the instants k dt.

    transition A_d, noise F, start S: (n, n), all lower triangular; output C: (m, n).
    """

    transition: Array
    noise: Array
    start: Array
    output: Array

    def leading(self, states: int, outputs: int) -> "SampledProcess":
        """Return the cascade cut behind its first `states` lags; its first `outputs` outputs must not need more."""
        n, m = states, outputs
        assert not self.output[:m, n:].any(), "a kept output reads a dropped state"
        return SampledProcess(self.transition[:n, :n], self.noise[:n, :n], self.start[:n, :n], self.output[:m, :n])


def gauss_markov(correlation_time: float) -> LinearProcess:
    """Return the first-order process of unit variance with autocovariance exp(-|t| / correlation_time), time in s."""
    rate = 1.0 / correlation_time
    return LinearProcess(np.array([[-rate]]), np.array([np.sqrt(2.0 * rate)]), np.array([[1.0]]))


def discretize(process: LinearProcess, dt: float) -> SampledProcess:
    """Return the process sampled every dt seconds; nothing is approximated, so dt may exceed every lag."""
    from scipy.linalg import expm

    assert not np.triu(process.a, 1).any() and max(np.diag(process.a)) < 0.0, "A must be a cascade of stable lags"
    transition = np.asarray(expm(process.a * dt), np.float64)
    start = np.asarray(np.linalg.cholesky(stationary_covariance(process)), np.float64)
    return SampledProcess(transition, _noise_factor(process, dt), start, process.c)


def stationary_covariance(process: LinearProcess) -> Array:
    """Return the stationary covariance P (n, n) of the state."""
    from scipy.linalg import solve_continuous_lyapunov

    covariance = np.asarray(solve_continuous_lyapunov(process.a, -np.outer(process.b, process.b)), np.float64)
    return 0.5 * (covariance + covariance.T)


def sample(process: SampledProcess, normals: Array) -> Array:
    """Return the outputs (K, m) for standard normals (K, n): row 0 draws the stationary start, row k the step to k.

    States are run one after the other in a fixed order of operations, so the first rows do not depend on how many
    follow, nor the first states on how many follow them.
    """
    columns = np.ascontiguousarray(normals.T)
    states: list[Array] = []
    for i in range(len(process.transition)):
        drive = _mix(process.noise[i, : i + 1], columns)
        drive[0] = _mix(process.start[i, : i + 1], columns[:, :1])[0]
        for weight, state in zip(process.transition[i], states, strict=False):
            drive[1:] += weight * state[:-1]
        _recursion()(float(process.transition[i, i]), drive)
        states.append(drive)
    return np.stack([_mix(row, states) for row in process.output], axis=1)


@cache
def _recursion() -> Callable[[float, Array], None]:
    """Return the compiled loop x_k = pole x_(k-1) + drive_k, in place. (scipy.signal has it too, but takes 1.4 s to import.)"""
    from plant.backends.cache import keep_file
    from plant.backends.compiling import kernel

    return keep_file(kernel({})(_recursive_sum), Path(__file__))


def _recursive_sum(pole: float, drive: Array) -> None:
    for k in range(1, len(drive)):
        drive[k] += pole * drive[k - 1]


def _mix(weights: Array, columns: Array | list[Array]) -> Array:
    """Return sum_j weights[j] columns[j], added in order: a BLAS product may round differently with its length."""
    total = weights[0] * columns[0]
    for weight, column in zip(weights[1:], columns[1:], strict=False):
        total += weight * column
    return total


def _noise_factor(process: LinearProcess, dt: float) -> Array:
    from scipy.linalg import expm

    doublings = max(0, ceil(log2(dt * float(np.abs(np.diag(process.a)).max(axis=0)))))
    step = dt / 2**doublings
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    responses = expm(process.a * (0.5 * step * (nodes + 1.0))[:, None, None]) @ process.b
    factor = _lower_factor((responses * np.sqrt(0.5 * step * weights)[:, None]).T)
    for k in range(doublings):
        factor = _lower_factor(np.hstack([expm(process.a * (step * 2**k)) @ factor, factor]))
    return factor


def _lower_factor(m: Array) -> Array:
    """Return the lower triangular factor F of F F' = M M', diagonal >= 0."""
    lower = np.transpose(np.linalg.qr(m.T, mode="r"))
    return lower * np.where(np.diag(lower) < 0.0, -1.0, 1.0)
