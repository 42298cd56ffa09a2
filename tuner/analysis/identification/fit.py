"""Maximum likelihood of a vehicle's numbers: the model's outputs against the logs, its residuals whitened.

Gauss-Newton on the whitened residuals and the prior; between its runs the noise of each output is fitted anew. Intervals come
from the information of the data with the scores of blocks of time in the middle ("sandwich"; White, Econometrica 50, 1982), so
that they hold where residuals stay correlated.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plant.vehicle import Vehicle
from tuner.analysis.identification.model import actuator, lagging, predicted
from tuner.analysis.identification.parameters import Space
from tuner.analysis.identification.samples import OUTPUTS, Samples
from tuner.analysis.identification.whitening import autoregression, whitened

Array = NDArray[np.float64]

ROUNDS, STEPS, SMALL = 5, 12, 0.02
"""Fits of the noise, Gauss-Newton steps of each, and the step, in posterior standard deviations, that ends them."""
STEP = 1e-4
"""Of a difference quotient, in prior standard deviations."""
BLOCK = 0.2
"""Length of the blocks whose scores are taken as independent [s]: whitening leaves little correlation beyond."""


@dataclass(frozen=True, eq=False)
class Noise:
    """Noise of each output: coefficients of its autoregression and RMS of what drives it."""

    coefficients: tuple[Array, ...]
    drive: Array


@dataclass(frozen=True, eq=False)
class Fit:
    """A point and how far it is known.

    point (n,): coordinates. free (n,): those that the data moved; others stand at their prior. covariance (n, n): of all
    coordinates. information (n, n): of the data alone. noise: of the outputs.
    """

    space: Space
    point: Array
    free: NDArray[np.bool_]
    covariance: Array
    information: Array
    noise: Noise


@dataclass(frozen=True, eq=False)
class Problem:
    """The logs on their grids, the prior, and which samples (masks of 0 and 1) and outputs of what is compared count."""

    space: Space
    vehicle: Vehicle
    samples: tuple[Samples, ...]
    masks: tuple[Array, ...]
    outputs: tuple[bool, ...] = (True,) * len(OUTPUTS)

    def residuals(self, point: Array) -> list[Array]:
        """Return measured less predicted (m, 4) of every stretch."""
        numbers = self.space.numbers(point)
        return [
            part.measured - predicted(part, lagging(part, [actuator(numbers)])[0], numbers, self.vehicle)
            for part in self.samples
        ]

    def sensitivities(self, point: Array, columns: Sequence[int]) -> tuple[list[Array], list[Array]]:
        """Return residuals (m, 4) and their negative derivatives (m, 4, columns) of every stretch."""
        steps = STEP * self.space.deviations
        points = [point, *[point + steps[k] * (np.arange(len(point)) == k) for k in columns]]
        numbers = [self.space.numbers(entry) for entry in points]
        distinct = list(dict.fromkeys(actuator(entry) for entry in numbers))
        left, slopes = [], []
        for part in self.samples:
            lagged = dict(zip(distinct, lagging(part, distinct), strict=True))
            outputs = [predicted(part, lagged[actuator(entry)], entry, self.vehicle) for entry in numbers]
            left.append(part.measured - outputs[0])
            rows = [(moved - outputs[0]) / steps[k] for k, moved in zip(columns, outputs[1:], strict=True)]
            slopes.append(np.stack(rows, axis=-1))
        return left, slopes


def fitted(
    problem: Problem, start: Array, free: NDArray[np.bool_], told: Callable[[int, int], None] | None = None
) -> Fit:
    """Fit the free coordinates from a start; told(round, of): hears of progress."""
    point, columns = start.copy(), np.flatnonzero(free).tolist()
    everything = list(range(len(point)))
    prior = problem.space.precision
    noise = noise_of(problem, point)
    for k in range(ROUNDS):
        if told is not None:
            told(k, ROUNDS)
        reached = _climbed(problem, point, columns, noise, prior)
        still = k > 0 and np.array_equal(reached, point)
        point, noise = reached, noise_of(problem, reached)
        if still:
            break
    left, slopes = problem.sensitivities(point, everything)
    information, scores = _information(problem, left, slopes, noise)
    covariance = _covariance(problem.space, information, _middle(scores, free), free)
    return Fit(problem.space, point, free, covariance, information, noise)


def foreseen(problem: Problem, point: Array, free: NDArray[np.bool_]) -> Fit:
    """Return the fit to be expected of flights of the vehicle at a point, where what is left over is noise (Cramer and Rao)."""
    noise = noise_of(problem, point)
    left, slopes = problem.sensitivities(point, list(range(len(point))))
    information, _ = _information(problem, left, slopes, noise)
    return Fit(problem.space, point, free, foreseen_covariance(problem.space, information, free), information, noise)


def foreseen_covariance(space: Space, information: Array, free: NDArray[np.bool_]) -> Array:
    """Return the covariance (n, n) of all coordinates that data of this information leave."""
    return _covariance(space, information, information[np.ix_(free, free)], free)


def noise_of(problem: Problem, point: Array) -> Noise:
    """Fit the noise of every output at a point."""
    left = problem.residuals(point)
    found = [autoregression([part[:, k] for part in left], problem.masks) for k in range(len(OUTPUTS))]
    return Noise(tuple(a for a, _ in found), np.array([drive for _, drive in found]))


def _white(problem: Problem, series: Sequence[Array], noise: Noise) -> list[Array]:
    """Return series (m, 4, ...) whitened, over the RMS of the noise, zero where samples do not count."""
    found = []
    for part, mask in zip(series, problem.masks, strict=True):
        weights = np.array(problem.outputs) / noise.drive
        channels = [weights[k] * whitened(part[:, k], a) for k, a in enumerate(noise.coefficients)]
        white = np.stack(channels, axis=1)
        found.append(white * mask.reshape(-1, *[1] * (white.ndim - 1)))
    return found


def _climbed(problem: Problem, point: Array, columns: list[int], noise: Noise, prior: Array) -> Array:
    """Return the point after Gauss-Newton steps, each shortened until the likelihood grows."""
    centre, cost = problem.space.centre, _cost(problem, point, noise, prior)
    for _ in range(STEPS):
        left, slopes = problem.sensitivities(point, columns)
        white, steep = _white(problem, left, noise), _white(problem, slopes, noise)
        j = np.concatenate([part.reshape(-1, len(columns)) for part in steep])
        e = np.concatenate([part.ravel() for part in white])
        own = prior[np.ix_(columns, columns)]
        hessian = j.T @ j + own
        step = np.linalg.solve(hessian, j.T @ e - own @ (point - centre)[columns])
        if np.sqrt(step @ hessian @ step) < SMALL * np.sqrt(len(columns)):
            return point
        scale = 1.0
        while True:
            moved = point.copy()
            moved[columns] += scale * np.clip(step, -1.0, 1.0)
            reached = _cost(problem, moved, noise, prior)
            if reached <= cost or scale < 1e-3:
                break
            scale *= 0.5
        if reached > cost:
            return point
        point, cost = moved, reached
    return point


def _cost(problem: Problem, point: Array, noise: Noise, prior: Array) -> float:
    with np.errstate(over="ignore", invalid="ignore"):
        white = _white(problem, problem.residuals(point), noise)
    off = point - problem.space.centre
    cost = sum(float(np.sum(part**2)) for part in white) + float(off @ prior @ off)
    return cost if np.isfinite(cost) else np.inf


def _information(problem: Problem, left: list[Array], slopes: list[Array], noise: Noise) -> tuple[Array, Array]:
    """Return the data's information (n, n), and the scores (blocks, n) of blocks of time."""
    white, steep = _white(problem, left, noise), _white(problem, slopes, noise)
    n = slopes[0].shape[-1]
    information, scores = np.zeros((n, n)), []
    for part, e, j in zip(problem.samples, white, steep, strict=True):
        information += np.einsum("mka,mkb->ab", j, j)
        rows = np.einsum("mka,mk->ma", j, e)
        width = max(round(BLOCK / (part.period * part.share)), 1)
        scores += [rows[k : k + width].sum(axis=0) for k in range(0, len(rows), width)]
    return information, np.array([row for row in scores if row.any()])


def _middle(scores: Array, free: NDArray[np.bool_]) -> Array:
    """Return the sum of the squared scores (blocks, n) of the free coordinates, for as many blocks as are not used up by them."""
    blocks = len(scores)
    return scores[:, free].T @ scores[:, free] * (blocks / max(blocks - np.count_nonzero(free), 1))


def _covariance(space: Space, information: Array, middle: Array, free: NDArray[np.bool_]) -> Array:
    """Return the covariance (n, n) of all coordinates: what the data tell of the free ones, and the prior of the others.

    middle: covariance of the scores of the free ones. A free coordinate leans on those that are held: an error of the prior there
    moves it by the sensitivity of the optimum.
    """
    n, held, prior = len(free), ~free, space.precision
    inner = np.linalg.inv(information[np.ix_(free, free)] + prior[np.ix_(free, free)])
    spread = np.zeros((n, n))
    spread[np.ix_(free, free)] = inner @ (middle + prior[np.ix_(free, free)]) @ inner
    lean = np.zeros((n, n))
    lean[held, held] = 1.0
    lean[np.ix_(free, held)] = -inner @ (information + prior)[np.ix_(free, held)]
    still = np.zeros((n, n))
    still[np.ix_(held, held)] = space.covariance[np.ix_(held, held)]
    return spread + lean @ still @ lean.T
