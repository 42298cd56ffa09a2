"""Slopes of a fit to its parameters, and the covariance that follows."""

import numpy as np

from tuner.extensions.plant_fit.estimate import Projection, Solution
from tuner.extensions.plant_fit.noise import whiten

Array = np.ndarray
DIFFERENCE = 1e-4
"""Step of differences in shape parameters, which are logarithms."""
DEAD_TIME_DIFFERENCE = 0.05
"""Step of differences in a dead time, in samples."""
MIN_INFORMATION = 1e-8
"""Least singular value of the normalized slopes, over the largest, of a direction that the data show."""


def jacobian_of(solution: Solution, slopes: list[Array]) -> Array:
    """Return the slopes (samples, k) of prediction errors, but for their sign.

    The order is plant, offsets, noise model.
    """
    noise = solution.noise
    pairs = zip(slopes, solution.residuals, strict=True)
    return np.vstack([np.column_stack([whiten(slope, noise), _past(left, len(noise))]) for slope, left in pairs])


def covariance_of(solution: Solution, jacobian: Array, n_outliers: int) -> tuple[Array, float]:
    """Return the covariance of all parameters, and the prediction error variance.

    The prediction errors are white, so it is their variance over the information matrix of all parameters together: in a closed
    loop those of plant and noise are correlated.

    Args:
        solution: Fit to all of the record.
        jacobian: Slopes of its prediction errors.
        n_outliers: Number of samples that are left out.
    """
    degrees = max(len(solution.errors) - n_outliers - jacobian.shape[1], 1)
    variance = solution.cost / degrees
    size = np.linalg.norm(jacobian, axis=0)
    size[size == 0.0] = 1.0
    # Initial states and offsets can be alike, so directions without information are left out.
    inverse = np.linalg.pinv(jacobian / size, rcond=MIN_INFORMATION)
    return variance * (inverse @ inverse.T) / np.outer(size, size), variance


def _past(series: Array, order: int) -> Array:
    n = len(series)
    return np.column_stack([np.zeros((n - order, 0)), *(-series[order - k : n - k] for k in range(1, order + 1))])


def slopes_of(projection: Projection, solution: Solution) -> list[Array]:
    """Return the slopes of each experiment's output (samples, k).

    The order is shapes, dead times, linear parameters.
    """
    m, n = solution.shape.shape
    late = m if solution.structure.has_dead_time else 0
    middle = np.concatenate([solution.shape.ravel(), solution.dead_times])
    steps = np.concatenate(
        [np.full(m * n, DIFFERENCE), np.full(late, DEAD_TIME_DIFFERENCE * projection.problem.period)]
    )

    def outputs(parameters: Array) -> list[Array]:
        columns = projection.matrices(parameters[: m * n].reshape(m, n), parameters[m * n :])
        return [each @ solution.linear for each in columns]

    linear = projection.matrices(solution.shape, solution.dead_times)
    slopes: list[list[Array]] = [[] for _ in linear]
    for i, step in enumerate(steps):
        ahead, behind = middle.copy(), middle.copy()
        ahead[i] += step
        # No dead time is below 0.
        behind[i] = behind[i] - step if i < m * n else max(behind[i] - step, 0.0)
        for columns, high, low in zip(slopes, outputs(ahead), outputs(behind), strict=True):
            columns.append((high - low) / (ahead[i] - behind[i]))
    return [np.column_stack([*columns, each]) for columns, each in zip(slopes, linear, strict=True)]
