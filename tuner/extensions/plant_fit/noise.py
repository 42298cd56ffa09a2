"""The noise of a record: outliers, an autoregressive model of what a plant leaves over, and its parts for a study.

Prediction errors of an autoregressive model of enough order are white whatever the spectrum of the noise. Parameters of plant
and noise that minimise them together are consistent for open and for closed loops (L. Ljung, System Identification, 2nd edition,
chapter 13).
"""

from typing import NamedTuple

import numpy as np
from scipy.ndimage import median_filter

Array = np.ndarray
MAX_NOISE_ORDER = 12
OUTLIER_DISTANCE = 8.0
"""Distance from the median of neighbours, in robust standard deviations, from which a sample is an outlier."""
WINDOW_LENGTH = 5
GAUSSIAN_MAD = 1.4826
MAX_OUTLIERS = 0.1
"""Largest share of a record that can be outliers."""


def quantum_of(series: Array) -> float:
    """Return the step of a quantised series, otherwise 0."""
    values = np.unique(series)
    steps = np.diff(values)
    if len(steps) < 2 or len(values) > len(series) / 3:
        return 0.0
    smallest = float(np.quantile(steps, 0.05))
    multiples = steps / smallest
    return smallest if np.max(np.abs(multiples - np.round(multiples))) < 0.02 else 0.0


def outliers_in(residual: Array, quantum: float) -> Array:
    """Return the indices of samples far from the median around them."""
    rest = residual - median_filter(residual, WINDOW_LENGTH, mode="nearest")
    # A sample that is the median itself says nothing of the scale.
    moved = np.abs(rest[rest != 0.0])
    if len(moved) == 0:
        return np.zeros(0, dtype=int)
    scale = max(GAUSSIAN_MAD * float(np.median(moved)), 0.5 * quantum)
    places = np.flatnonzero(np.abs(rest) > OUTLIER_DISTANCE * scale)
    return places if len(places) <= MAX_OUTLIERS * len(residual) else np.zeros(0, dtype=int)


def whiten(series: Array, noise: Array) -> Array:
    """Return prediction errors of columns (n, k) under coefficients (p,): the first p rows are left out."""
    n, p = len(series), len(noise)
    errors = series[p:].copy()
    for k, coefficient in enumerate(noise, 1):
        errors += coefficient * series[p - k : n - k]
    return errors


def fit_noise(residuals: list[Array], max_order: int = MAX_NOISE_ORDER) -> Array:
    """Return coefficients (p,) of an autoregressive model, ordered by Akaike's criterion.

    That of Schwarz leaves out terms of low-frequency noise, and intervals of the plant become too narrow.
    """
    top = min(max_order, min(len(each) for each in residuals) // 10)
    best: tuple[float, Array] = (np.inf, np.zeros(0))
    for order in range(top + 1):
        # All orders predict the same samples, else their errors do not compare.
        past = np.vstack([_lagged(each, order, top) for each in residuals])
        now = np.concatenate([each[top:] for each in residuals])
        coefficients = np.linalg.lstsq(past, -now, rcond=None)[0] if order else np.zeros(0)
        mean_square = float(np.mean((now + past @ coefficients) ** 2)) if order else float(np.mean(now**2))
        n = len(now)
        score = n * np.log(max(mean_square, 1e-300)) + 2.0 * order
        if score < best[0]:
            best = score, coefficients
    return best[1]


def _lagged(series: Array, order: int, top: int) -> Array:
    n = len(series)
    return np.column_stack([series[top - k : n - k] for k in range(1, order + 1)]) if order else np.zeros((n - top, 0))


def fill_outliers(series: Array, places: Array, noise: Array) -> Array:
    """Return a residual whose outliers have their conditional expectation."""
    if len(places) == 0:
        return series
    n, p = len(series), len(noise)
    filled = series.copy()
    filled[places] = 0.0
    if p == 0:
        return filled
    # Prediction errors change by a column of shifted coefficients for each outlier; only near ones overlap.
    taps = np.concatenate([[1.0], noise])
    errors = np.convolve(filled, taps)[:n]
    correlation = np.array([taps[: p + 1 - k] @ taps[k:] for k in range(p + 1)])
    distance = np.abs(places[:, None] - places[None, :])
    normal = np.where(distance <= p, correlation[np.minimum(distance, p)], 0.0)
    ahead = np.concatenate([errors, np.zeros(p)])
    right = np.array([taps @ ahead[place : place + p + 1] for place in places])
    filled[places] = -np.linalg.solve(normal + 1e-12 * np.eye(len(places)), right)
    return filled


class NoiseParts(NamedTuple):
    """White noise and coloured noise, rms, and its correlation time [s]."""

    white: float
    coloured: float
    correlation_time: float


def noise_parts(residuals: list[Array], period: float) -> NoiseParts:
    """Return white and first-order coloured noise with the autocovariances of residuals."""
    n = sum(len(each) for each in residuals)
    centred = [each - each.mean() for each in residuals]

    def covariance(lag: int) -> float:
        return sum(float(each[lag:] @ each[: len(each) - lag]) for each in centred) / n

    total = covariance(0)
    lags = np.arange(1, 9)
    values = np.array([covariance(int(lag)) for lag in lags])
    bound = 2.0 * total / np.sqrt(n)
    clear = int(np.argmax(values < bound)) if np.any(values < bound) else len(values)
    if clear < 2:
        return NoiseParts(float(np.sqrt(total)), 0.0, 0.0)
    slope, start = np.polyfit(lags[:clear], np.log(values[:clear]), 1)
    decay = min(float(slope), -1e-3)
    coloured = min(float(np.exp(start)), total)
    return NoiseParts(float(np.sqrt(total - coloured)), float(np.sqrt(coloured)), -period / decay)
