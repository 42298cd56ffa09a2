"""How far a fit may be believed, from windows that it did not use: the band that it predicts, and what it leaves over.

The band holds what the posterior leaves open of the numbers and the noise that the fit's own windows had. What is left over is
compared with what was measured frequency by frequency, and tested for being white behind the noise model (Ljung, System
Identification, 2nd ed., section 16.6).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tuner.analysis.identification.fit import Fit, Problem
from tuner.analysis.identification.prediction import Windows, cut, windowed
from tuner.analysis.identification.samples import OUTPUTS
from tuner.analysis.identification.whitening import ORDERS, whitened

Array = NDArray[np.float64]

QUANTILE = 1.96
LAGS = 25
"""Lags of the autocorrelation that are looked at, in samples of what is compared."""
HALF = 0.5
"""Share of the power at a frequency that the model must explain there."""


@dataclass(frozen=True, eq=False)
class Judged:
    """A fit judged on windows kept from it.

    windows: what was measured and predicted there. spread (w, m, 4): standard deviations of the prediction, in the units of
    the windows. correlation (lags, 4): of what the noise model leaves over, from lag 1 on. counted: samples behind each of them.
    """

    windows: Windows
    spread: Array
    correlation: Array
    counted: int

    @property
    def covered(self) -> Array:
        """Share (4,) of what was measured that lies within the 95 % band."""
        off = np.abs(self.windows.measured - self.windows.modelled)
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
        """Frequencies (f,) [Hz], and RMS over the square root of a Hz (f, 4) of what was measured and of what is left over."""
        period = float(np.median(np.diff(self.windows.time, axis=1)))
        measured, left = (
            density(part, period) for part in (self.windows.measured, self.windows.measured - self.windows.modelled)
        )
        frequency = np.asarray(np.fft.rfftfreq(self.windows.measured.shape[1], period)[1:], np.float64)
        return frequency, measured, left

    @property
    def reach(self) -> Array:
        """Highest frequency (4,) [Hz] up to which the model explains more than `HALF` of the power, without a break."""
        frequency, measured, left = self.spectra
        good = left**2 < (1.0 - HALF) * measured**2
        ends = np.where(good.all(axis=0), len(frequency), np.argmin(good, axis=0))
        return np.where(ends > 0, frequency[np.maximum(ends - 1, 0)], 0.0)


def judged(fit: Fit, problem: Problem) -> Judged:
    """Judge a fit on the windows that the masks of its problem kept from it."""
    columns = list(range(len(fit.point)))
    left, slopes = problem.sensitivities(fit.point, columns)
    used = cut(problem, left, 1.0)
    noise = np.mean(used**2, axis=0)
    steep = np.stack([cut(problem, [part[..., k] for part in slopes], 0.0) for k in columns], axis=-1)
    numbers = np.einsum("wmka,ab,wmkb->wmk", steep, fit.covariance, steep)
    correlation, counted = autocorrelation(fit, problem, left)
    return Judged(windowed(problem, fit.point), np.sqrt(numbers + noise), correlation, counted)


def autocorrelation(fit: Fit, problem: Problem, left: list[Array]) -> tuple[Array, int]:
    """Return autocorrelations (lags, 4) of what the noise model leaves over where the fit did not look, and their samples."""
    products, powers, counted = np.zeros((LAGS, len(OUTPUTS))), np.zeros(len(OUTPUTS)), 0
    for part, mask in zip(left, problem.masks, strict=True):
        white = np.column_stack([whitened(part[:, k], a) for k, a in enumerate(fit.noise.coefficients)])
        chosen = (mask == 0.0) & (np.arange(len(mask)) >= ORDERS[-1])
        powers += np.sum(white[chosen] ** 2, axis=0)
        counted += int(np.count_nonzero(chosen))
        for lag in range(1, LAGS + 1):
            both = chosen[lag:] & chosen[:-lag]
            products[lag - 1] += np.sum((white[lag:] * white[:-lag])[both], axis=0)
    return products / np.maximum(powers, 1e-300), max(counted, 1)


def density(series: Array, period: float) -> Array:
    """Return the RMS over the square root of a Hz (f, 4) of windows (w, m, 4), without the mean, with Hann's weights."""
    weights = np.hanning(series.shape[1] + 2)[1:-1]
    transform = np.fft.rfft(series * weights[:, None], axis=1)[:, 1:]
    return np.sqrt(2.0 * period * np.mean(np.abs(transform) ** 2, axis=0) / np.sum(weights**2))
