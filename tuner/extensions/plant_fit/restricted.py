"""The restricted likelihood of a noise model.

A fitted plant and an estimated offset take slow noise over, so a model of the rest has too little power at low frequencies, and
95 % intervals contain the truth 90 times in 100. The restricted likelihood adds the determinant of the plant's information to
the sum of squares, which removes this bias (W. Cheang and G. Reinsel, "Bias reduction of autoregressive estimates in time series
regression model through restricted maximum likelihood", J. Am. Stat. Assoc. 95, 2000). Intervals are those of Student's t, with
degrees of freedom from the variance of each variance (M. Kenward and J. Roger, Biometrics 53, 1997).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import minimize

Array = np.ndarray
RIDGE = 1e-8
"""Least distance of columns from each other, which may be alike, over their norm."""
REJECTION_CRITERION = 1e9
"""Criterion of a model that is not stationary: finite, because the search takes its differences."""
MAX_STEPS, MIN_SLOPE = 20, 1e-2
RELATIVE_STEP = 0.1
"""Step of differences, in standard errors of the noise model."""


@dataclass(frozen=True)
class RestrictedLikelihood:
    """Restricted likelihood of an autoregressive model of the noise.

    Attributes:
        first: Slopes to the plant's k parameters, then the residual, of the first p samples of each experiment (p, k + 1).
        columns: The same of the other samples, shifted by 0 to p samples (p + 1, rows, k + 1), turned into few rows with the same
            products.
        size: Norm (k + 1,) by which each column is divided.
        n_samples: Number of samples.
    """

    first: list[Array]
    columns: Array
    size: Array
    n_samples: int

    @classmethod
    def of(cls, slopes: list[Array], residuals: tuple[Array, ...], order: int) -> "RestrictedLikelihood":
        """Return the likelihood of models of an order; slopes: of each experiment (samples, k)."""
        joined = [np.column_stack(pair) for pair in zip(slopes, residuals, strict=True)]
        size = np.linalg.norm(np.vstack(joined), axis=0)
        size[size == 0.0] = 1.0
        joined = [each / size for each in joined]
        shifts = [np.hstack([each[order - k : len(each) - k] for k in range(order + 1)]) for each in joined]
        few = np.asarray(np.linalg.qr(np.vstack(shifts), mode="r"))
        columns = few.reshape(len(few), order + 1, len(size)).transpose(1, 0, 2)
        return cls([each[:order] for each in joined], columns, size, sum(len(each) for each in joined))

    @property
    def degrees(self) -> int:
        """Samples without the plant's parameters."""
        return max(self.n_samples - len(self.size) + 1, 1)

    def _triangle(self, noise: Array, beginning: Array) -> Array:
        """Return the triangular factor (k + 1, k + 1) of the whitened columns; beginning: of the first samples."""
        whitened = np.tensordot(np.concatenate([[1.0], noise]), self.columns, 1)
        rows = [beginning @ each for each in self.first]
        return np.asarray(np.linalg.qr(np.vstack([*rows, whitened, RIDGE * np.eye(len(self.size))]), mode="r"))

    def criterion(self, noise: Array) -> float:
        """Return minus twice the logarithm of the likelihood of coefficients (p,)."""
        beginning = beginning_of(noise)
        if beginning is None:
            return REJECTION_CRITERION
        logarithms = np.log(np.abs(np.diag(self._triangle(noise, beginning))))
        spread = -2.0 * len(self.first) * float(np.sum(np.log(np.diag(beginning))))
        return float(2.0 * self.degrees * logarithms[-1] + 2.0 * np.sum(logarithms[:-1])) + spread

    @cached_property
    def _unit(self) -> Array:
        """Steps (p, p) of the noise model by one standard error in independent directions."""
        residual = self.columns[:, :, -1].T
        noise, *_ = np.linalg.lstsq(residual[:, 1:], -residual[:, 0], rcond=None)
        error = residual[:, 0] + residual[:, 1:] @ noise
        _, values, turned = np.linalg.svd(residual[:, 1:], full_matrices=False)
        return turned.T * np.linalg.norm(error) / np.sqrt(self.n_samples) / np.maximum(values, RIDGE)

    def best(self, start: Array) -> Array:
        """Return the coefficients that maximise the likelihood, from those of least squares."""
        if len(start) == 0 or beginning_of(start) is None:
            return start
        minimum = minimize(
            lambda steps: self.criterion(start + self._unit @ steps), np.zeros(len(start)), method="BFGS",
            options={"maxiter": MAX_STEPS, "gtol": MIN_SLOPE},
        )  # fmt: skip
        return start + self._unit @ minimum.x

    def degrees_of(self, direction: Array, noise: Array) -> float:
        """Return the degrees of freedom of an estimate's variance.

        Args:
            direction: Slopes of the estimate to the plant's first parameters.
            noise: Coefficients (p,) of the noise model.
        """
        padded = np.zeros(len(self.size) - 1)
        padded[: len(direction)] = direction / self.size[: len(direction)]

        beginning = beginning_of(noise)
        if beginning is None:
            return float(self.degrees)
        rates = []
        for step in RELATIVE_STEP * self._unit.T:
            ends = [self._variance(padded, noise + sign * step, beginning) for sign in (1.0, -1.0)]
            rates.append((np.log(ends[0]) - np.log(ends[1])) / (2.0 * RELATIVE_STEP))
        return 2.0 / (2.0 / self.degrees + float(np.sum(np.square(rates))))

    def _variance(self, direction: Array, noise: Array, beginning: Array) -> float:
        triangle = self._triangle(noise, beginning)
        deviation = np.linalg.solve(triangle[:-1, :-1].T, direction) * triangle[-1, -1]
        return float(deviation @ deviation) + 1e-300


def beginning_of(noise: Array) -> Array | None:
    """Return the rows (p, p) that whiten the first samples, by Levinson's recursion; None for a model that is not stationary."""
    rows, variance = np.zeros((len(noise), len(noise))), 1.0
    taps = noise
    for order in range(len(noise) - 1, -1, -1):
        reflection = taps[order]
        if not abs(reflection) < 1.0:
            return None
        variance /= 1.0 - reflection**2
        taps = (taps[:order] - reflection * taps[:order][::-1]) / (1.0 - reflection**2)
        rows[order, : order + 1] = np.concatenate([taps[::-1], [1.0]]) / np.sqrt(variance)
    return rows
