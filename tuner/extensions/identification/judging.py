"""Validation of a fit on held-out windows: coverage of its predictions, and its residuals.

The band holds what the posterior leaves open of the numbers and the noise that the fit's own windows had. Residuals are compared
with the measurement frequency by frequency, and tested for whiteness behind the noise model (Ljung, System Identification, 2nd
ed., section 16.6).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tuner.extensions.vehicle_fit.fit import Fit, Problem, split_covariance
from tuner.extensions.vehicle_fit.prediction import PredictionWindows, cut, held_out, prediction_windows
from tuner.extensions.vehicle_fit.random_effects import QUANTILE
from tuner.extensions.vehicle_fit.samples import OUTPUTS
from tuner.extensions.vehicle_fit.whitening import ORDERS

Array = NDArray[np.float64]

LAGS = 25
"""Lags of the autocorrelation that are looked at, in samples of what is compared."""
LEVEL = 0.95
"""Level of the band."""
HALF = 0.5
"""Share of the power at a frequency that the model must explain there."""


@dataclass(frozen=True, eq=False)
class FitValidation:
    """Validation of a fit on held-out windows.

    Attributes:
        windows: Measured and predicted outputs.
        spread (w, m, 4): Standard deviations of the prediction, in the units of the windows.
        correlation (lags, 4): Correlation of the residuals that the noise model leaves over, from lag 1 on.
        counted: Samples behind each correlation.
    """

    windows: PredictionWindows
    spread: Array
    correlation: Array
    counted: int

    @property
    def covered(self) -> Array:
        """Share (4,) of what was measured that lies within the 95 % band."""
        off = np.abs(self.windows.measured - self.windows.modeled)
        return np.mean(off <= QUANTILE * self.spread, axis=(0, 1))

    @property
    def bound(self) -> float:
        """Size within which 95 % of the autocorrelations of white noise lie."""
        return QUANTILE / np.sqrt(self.counted)

    @property
    def correlated(self) -> Array:
        """Share (4,) of lags beyond the bound; 0.05 of white noise."""
        return np.mean(np.abs(self.correlation) > self.bound, axis=0)

    @cached_property
    def spectra(self) -> tuple[Array, Array, Array]:
        """Frequencies (f,) [Hz], and amplitude densities (f, 4) [1/sqrt(Hz)] of measurements and of residuals."""
        period = float(np.median(np.diff(self.windows.time, axis=1)))
        measured, residuals = (
            density(part, period) for part in (self.windows.measured, self.windows.measured - self.windows.modeled)
        )
        frequency = np.asarray(np.fft.rfftfreq(self.windows.measured.shape[1], period)[1:], np.float64)
        return frequency, measured, residuals

    @property
    def reach(self) -> Array:
        """Bandwidth (4,) [Hz]: below it the model explains more than `HALF` of the power."""
        frequency, measured, residuals = self.spectra
        good = residuals**2 < (1.0 - HALF) * measured**2
        ends = np.where(good.all(axis=0), len(frequency), np.argmin(good, axis=0))
        return np.where(ends > 0, frequency[np.maximum(ends - 1, 0)], 0.0)


def validate_fit(fit: Fit, problem: Problem) -> FitValidation:
    """Validate a fit on the held-out windows of its problem."""
    columns = list(range(len(fit.estimate)))
    residuals, jacobians = problem.sensitivities(fit.estimate, columns)
    used = cut(problem, residuals, 1.0)
    noise = _noise_variance(used)
    window_jacobians = np.stack([cut(problem, [part[..., k] for part in jacobians], 0.0) for k in columns], axis=-1)
    # How the delay splits leaves its sum, and so the prediction, as it is.
    covariance = fit.covariance - split_covariance(fit.space, fit.estimate, fit.free)
    numbers = np.einsum("wmka,ab,wmkb->wmk", window_jacobians, covariance, window_jacobians)
    correlation, counted = autocorrelation(fit, problem, residuals)
    return FitValidation(prediction_windows(problem, fit.estimate), np.sqrt(numbers + noise), correlation, counted)


def _noise_variance(used: Array) -> Array:
    """Return the variance (m, 4) of residuals (w, m, 4) for a 95 % band.

    It is scaled so that the band holds 95 % of them. Gusts come and go: windows of a real flight differ in size by 2 to 3, and
    a normal band of their mean power was left by 11 % of pitch.
    """
    variance = np.mean(used**2, axis=0)
    reached = np.quantile(used**2 / np.maximum(variance, 1e-300), LEVEL, axis=(0, 1))
    return variance * reached / QUANTILE**2


def autocorrelation(fit: Fit, problem: Problem, residuals: list[Array]) -> tuple[Array, int]:
    """Return autocorrelations (lags, 4) of the whitened held-out residuals, and the number of samples."""
    products, powers, counted = np.zeros((LAGS, len(OUTPUTS))), np.zeros(len(OUTPUTS)), 0
    for part, mask, residual in zip(problem.samples, problem.masks, residuals, strict=True):
        white = fit.noise.whiten(residual)
        chosen = held_out(part, mask) & (np.arange(len(mask)) >= ORDERS[-1])
        powers += np.sum(white[chosen] ** 2, axis=0)
        counted += int(np.count_nonzero(chosen))
        for lag in range(1, LAGS + 1):
            both = chosen[lag:] & chosen[:-lag]
            products[lag - 1] += np.sum((white[lag:] * white[:-lag])[both], axis=0)
    return products / np.maximum(powers, 1e-300), max(counted, 1)


def density(series: Array, period: float) -> Array:
    """Return the amplitude density (f, 4) [1/sqrt(Hz)] of windows (w, m, 4): Hann-weighted, without the mean."""
    weights = np.hanning(series.shape[1] + 2)[1:-1]
    transform = np.fft.rfft(series * weights[:, None], axis=1)[:, 1:]
    return np.sqrt(2.0 * period * np.mean(np.abs(transform) ** 2, axis=0) / np.sum(weights**2))
