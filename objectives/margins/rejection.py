"""Rejection bandwidth and group delay of stable loops.

Disturbance rejection bandwidth: the lowest frequency at which the sensitivity S = 1 + T comes up through -3 dB; its peak is Ms.
Group delay at the highest gain crossover: -d arg L/dw with L = -T/(1 + T), so -Im(T'/(T (1 + T))): filters and lags of the
whole chain. ADS-33E-PRF, section 3.2; C. L. Blanken et al., Test Guide for ADS-33E-PRF, 2008, for disturbance rejection.
"""

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from objectives.margins.frequency import Modes
from plant.backends.cache import keep_file
from plant.backends.compiling import kernel

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# Squared sensitivity at -3 dB, points of the grid that are enough to bracket it, and halvings that find it.
REJECTED, POINTS, HALVINGS = 0.5, 80, 50
OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract", "nsz"}}


def rejection_bandwidth(modes: Modes, residues: Complex, grid: Array, h: float) -> Array:
    """Lowest frequency [rad/s], (n, k), at which S comes up through -3 dB; 0 for loops that are not stable or reject nothing.

    residues (n, k, b): from the signal injected into each of k channels to its command.
    """
    bandwidths = np.zeros(residues.shape[:2])
    thinned = np.ascontiguousarray(grid[0, 1 :: max(1, grid.shape[1] // POINTS)])
    lowest_levels(thinned, modes.poles, np.ascontiguousarray(residues), modes.stable, h, bandwidths)
    return bandwidths


def lowest_levels(
    grid: Array, poles: Complex, residues: Complex, stable: NDArray[np.bool_], h: float, out: Array
) -> None:
    """Fill found (n, k) of the stable ones of loops with poles (n, b) and residues (n, k, b); grid (f,) [rad/s]."""
    for i in range(len(poles)):
        for j in range(residues.shape[1]):
            low, high = 0.0, 0.0
            if stable[i]:
                for w in grid:
                    t = 1.0 + 0.0j
                    z = complex(math.cos(w * h), math.sin(w * h))
                    for b in range(poles.shape[1]):
                        t += residues[i, j, b] / (z - poles[i, b])
                    if t.real * t.real + t.imag * t.imag >= REJECTED:
                        high = w
                        break
                    low = w
            if low > 0.0 and high > 0.0:
                for _ in range(HALVINGS):
                    middle = 0.5 * (low + high)
                    t = 1.0 + 0.0j
                    z = complex(math.cos(middle * h), math.sin(middle * h))
                    for b in range(poles.shape[1]):
                        t += residues[i, j, b] / (z - poles[i, b])
                    if t.real * t.real + t.imag * t.imag >= REJECTED:
                        high = middle
                    else:
                        low = middle
                out[i, j] = high


lowest_levels = keep_file(kernel(OPTIONS)(lowest_levels), Path(__file__))


def group_delay(modes: Modes, residues: Complex, crossover: Array, h: float) -> Array:
    """Group delay [s], (n, k), of loops at their gain crossovers (n, k) [rad/s]; 0 where there is none."""
    z = np.exp(1j * crossover * h)[..., None]
    away = z - modes.poles[:, None, :]
    t = np.sum(residues / away, axis=-1)
    slope = -1j * h * np.sum(residues * z / (away * away), axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        delay = -np.imag(slope / (t * (1.0 + t)))
    return np.where((crossover > 0.0) & np.isfinite(delay), delay, 0.0)
