"""Bartlett's correction of likelihood profiles for the curvature of a plant's responses.

Of a model with straight responses, the squares that a true value loses are those of one degree of freedom. A curved model loses
more on average: with slopes J that are orthonormal and second derivatives A normal to them, the fit of all parameters gains
their number plus

    b = s^2 (1/2 sum |A_ij|^2 - 1/4 |sum A_ii|^2)

in units of the variance s^2 of the prediction errors (D. Lawley, Biometrika 43, 1956, for normal errors). With a value given,
the other parameters move on a surface that is curved too, and the difference of both b is the correction of the mean.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tuner.extensions.plant_fit.estimate import Projection, Solution
from tuner.extensions.plant_fit.noise import whiten

Array = np.ndarray
STEP = 0.02
"""Step of second differences of a shape parameter, which is a logarithm."""
DEAD_TIME_STEP = 0.15
"""The same of a dead time, in samples."""
NUMBER_STEP = 1e-2
"""Step of second differences of a number of the plant, in standard deviations."""


@dataclass(frozen=True)
class Curvature:
    """Second derivatives of whitened responses, for orthonormal slopes.

    Attributes:
        scale: Slopes of the parameters to the coordinates (k, k).
        normal: Second derivatives in normal directions (k, k, directions).
        tangent: Second derivatives along the coordinates (k, k, k).
        variance: Variance of the prediction errors.
    """

    scale: Array
    normal: Array
    tangent: Array
    variance: float

    @classmethod
    def of(cls, projection: Projection, solution: Solution, slopes: Array, variance: float) -> "Curvature":
        """Return the curvature at a fit; slopes: whitened, of plant, offsets and noise (samples, k)."""
        pairs, bends = second_derivatives(projection, solution)
        orthonormal, triangle = np.linalg.qr(slopes)
        scale = np.linalg.pinv(triangle)
        along = orthonormal.T @ bends
        across = np.asarray(np.linalg.qr(bends - orthonormal @ along, mode="r")).T
        k = slopes.shape[1]
        parts = np.zeros((k, k, k + across.shape[1]))
        for (i, j), tangent, normal in zip(pairs, along.T, across, strict=True):
            parts[i, j] = parts[j, i] = np.concatenate([tangent, normal])
        turned = np.einsum("ia,ijn,jb->abn", scale, parts, scale)
        return cls(scale, turned[..., k:], turned[..., :k], variance)

    def mean_loss(self, slope: Array, bend: Array) -> float:
        """Return the mean loss of a true value over the variance.

        It is 1 for straight responses.

        Args:
            slope: Derivatives of the number (n,) to the first n parameters.
            bend: Second derivatives (n, n).
        """
        n = len(slope)
        gradient = slope @ self.scale[:n]
        length = float(np.linalg.norm(gradient))
        if length == 0.0:
            return 1.0
        turned = np.linalg.svd(gradient[None])[2]
        direction, others = turned[0] * np.sign(turned[0] @ gradient), turned[1:]
        # The other parameters leave the tangent along the gradient, and turn as the number bends.
        leaving = self.tangent @ direction - self.scale[:n].T @ bend @ self.scale[:n] / length
        surface = np.concatenate([self.normal, leaving[..., None]], axis=2)
        inner = np.einsum("ai,ijn,bj->abn", others, surface, others)
        return 1.0 + self.variance * (_excess(self.normal) - _excess(inner))


def _excess(bends: Array) -> float:
    """Return b over the variance; bends: normal second derivatives (k, k, directions)."""
    return float(0.5 * np.sum(bends**2) - 0.25 * np.sum(np.einsum("aan->n", bends) ** 2))


def second_derivatives(projection: Projection, solution: Solution) -> tuple[list[tuple[int, int]], Array]:
    """Return pairs of the plant's parameters, and their whitened second derivatives (samples, pairs).

    Pairs of two inputs or of two numerators are left out: their second derivatives are 0.
    """
    m, n = solution.shape.shape
    late = m if solution.structure.has_dead_time else 0
    count = solution.structure.zeros + 1
    middle = np.concatenate([solution.shape.ravel(), solution.dead_times[:late]])
    steps = np.concatenate([np.full(m * n, STEP), np.full(late, DEAD_TIME_STEP * projection.problem.period)])
    # Differences to both sides need a dead time that can be shorter.
    middle[m * n :] = np.maximum(middle[m * n :], steps[m * n :])

    def columns(*moved: tuple[int, float]) -> Array:
        at = middle.copy()
        for i, sign in moved:
            at[i] += sign * steps[i]
        dead_times = at[m * n :] if late else solution.dead_times
        parts = projection.matrices(at[: m * n].reshape(m, n), dead_times)
        return np.vstack([whiten(part, solution.noise) for part in parts])

    center = columns()
    ends = [(columns((i, 1.0)), columns((i, -1.0))) for i in range(len(middle))]
    pairs: list[tuple[int, int]] = []
    bends: list[Array] = []
    for j in range(m):
        indices = [*range(j * n, (j + 1) * n), *([m * n + j] if late else [])]
        for place, i in enumerate(indices):
            ahead, behind = ends[i]
            pairs.append((i, i))
            bends.append((ahead + behind - 2.0 * center) @ solution.linear / steps[i] ** 2)
            for k in range(j * count, (j + 1) * count):
                pairs.append((i, len(middle) + k))
                bends.append((ahead[:, k] - behind[:, k]) / (2.0 * steps[i]))
            for other in indices[:place]:
                both = columns((i, 1.0), (other, 1.0)) + columns((i, -1.0), (other, -1.0))
                mixed = both + 2.0 * center - sum(ends[i]) - sum(ends[other])
                pairs.append((i, other))
                bends.append(mixed @ solution.linear / (2.0 * steps[i] * steps[other]))
    return pairs, np.column_stack(bends)


def bends_of(function: Callable[[Array], float], middle: Array, deviations: Array) -> tuple[Array, Array]:
    """Return first and second derivatives of a number to its parameters."""
    steps = NUMBER_STEP * np.maximum(deviations, 1e-9)
    units = np.diag(steps)
    center = function(middle)
    ends = np.array([[function(middle + unit), function(middle - unit)] for unit in units])
    slope = (ends[:, 0] - ends[:, 1]) / (2.0 * steps)
    # Numbers depend on few parameters, and most on one alone.
    moving = np.flatnonzero(np.any(ends != center, axis=1))
    bend = np.zeros((len(middle), len(middle)))
    for i in moving:
        bend[i, i] = (ends[i].sum() - 2.0 * center) / steps[i] ** 2
        for j in moving[moving < i]:
            both = function(middle + units[i] + units[j]) + function(middle - units[i] - units[j])
            bend[i, j] = bend[j, i] = (both + 2.0 * center - ends[i].sum() - ends[j].sum()) / (
                2.0 * steps[i] * steps[j]
            )
    return slope, bend
