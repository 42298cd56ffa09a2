"""Maximum a posteriori estimation of a vehicle's parameters.

Gauss-Newton on the whitened residuals of the model's outputs and the prior; between its runs the noise of each output is fitted
again. Intervals come from the information of the data with the scores of blocks of time in the middle ("sandwich"; White,
Econometrica 50, 1982), so that they hold where residuals stay correlated.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plant.quadrotor.vehicle import Vehicle
from tuner.extensions.vehicle_fit.marginal import marginal_moments, with_moments
from tuner.extensions.vehicle_fit.model import actuator, lagging, predicted
from tuner.extensions.vehicle_fit.parameters import ParameterSpace
from tuner.extensions.vehicle_fit.samples import OUTPUTS, LogSegment
from tuner.extensions.vehicle_fit.whitening import autoregression, leaky_sum, whitened

Array = NDArray[np.float64]

MAX_NOISE_FITS = 5
"""Fits of the noise."""
MAX_ITERATIONS = 12
"""Gauss-Newton iterations of each fit."""
STEP_TOLERANCE = 0.02
"""Step that ends them, in posterior standard deviations."""
DIFFERENCE_STEP = 1e-4
"""Step of a difference quotient, in prior standard deviations."""
SCANNED = np.arange(-6, 7)
"""Dead times that are tried around an estimate, in half periods of the grid. Between two periods a held command acts as their
mean, so each period has a minimum of its own: from 0 a fit ended at 0 where 2 ms were true.
"""
SCANNED_WITH, SCAN_ITERATIONS = ("lag_up", "lag_down", "gyro_delay", "inertia.x", "inertia.y"), 4
"""Coordinates that follow each of these, and Gauss-Newton iterations of theirs."""
SPLIT = 0.0025
"""Standard deviation of the gyro's share in the delay of rotors and gyro together [s]: a loop that answers the noise of its gyro
looks like one with a slower gyro, or with slower rotors where the gyro's low-pass is known. On 40 vehicles of an independent
simulator, logged at 500 Hz, it was off by 1 to 6 ms.
"""
LINEAR = ("drag_linear.z",)
"""Positive numbers that act linearly and that flights hardly identify: their posteriors are integrated."""
BLOCK = 0.2
"""Length of the blocks whose scores are taken as independent [s]: whitening leaves little correlation beyond."""


@dataclass(frozen=True, eq=False)
class Noise:
    """Noise of each output: coefficients of its autoregression and standard deviation of its innovations."""

    coefficients: tuple[Array, ...]
    innovation_std: Array

    def whiten(self, series: Array) -> Array:
        """Return the innovations (m, 4, ...) of a series of outputs."""
        summed = _summed(series)
        return np.stack([whitened(summed[:, k], a) for k, a in enumerate(self.coefficients)], axis=1)


@dataclass(frozen=True, eq=False)
class Fit:
    """An estimate and its covariance.

    Attributes:
        estimate (n,): Coordinates.
        free (n,): Mask of the fitted ones; others stay at their prior.
        covariance (n, n): Covariance of all coordinates.
        information (n, n): Information of the data alone.
        noise: Noise of the outputs.
    """

    space: ParameterSpace
    estimate: Array
    free: NDArray[np.bool_]
    covariance: Array
    information: Array
    noise: Noise


@dataclass(frozen=True, eq=False)
class Problem:
    """Log segments, prior, and masks (0 or 1) of the samples and outputs that count."""

    space: ParameterSpace
    vehicle: Vehicle
    samples: tuple[LogSegment, ...]
    masks: tuple[Array, ...]
    outputs: tuple[bool, ...] = (True,) * len(OUTPUTS)

    def residuals(self, point: Array) -> list[Array]:
        """Return measured less predicted outputs (m, 4) of every segment."""
        numbers = self.space.numbers(point)
        return [
            part.measured - predicted(part, lagging(part, [actuator(numbers)])[0], numbers, self.vehicle)
            for part in self.samples
        ]

    def sensitivities(self, point: Array, columns: Sequence[int]) -> tuple[list[Array], list[Array]]:
        """Return residuals (m, 4) and their negative Jacobians (m, 4, columns) of every segment."""
        steps = DIFFERENCE_STEP * self.space.prior_std
        points = [point, *[point + steps[k] * (np.arange(len(point)) == k) for k in columns]]
        numbers = [self.space.numbers(entry) for entry in points]
        distinct = list(dict.fromkeys(actuator(entry) for entry in numbers))
        residuals, jacobians = [], []
        for part in self.samples:
            lagged = dict(zip(distinct, lagging(part, distinct), strict=True))
            outputs = [predicted(part, lagged[actuator(entry)], entry, self.vehicle) for entry in numbers]
            residuals.append(part.measured - outputs[0])
            rows = [(moved - outputs[0]) / steps[k] for k, moved in zip(columns, outputs[1:], strict=True)]
            jacobians.append(np.stack(rows, axis=-1))
        return residuals, jacobians


def fit_parameters(
    problem: Problem,
    start: Array,
    free: NDArray[np.bool_],
    on_progress: Callable[[int, int], None] | None = None,
    scan: bool = False,
) -> Fit:
    """Fit the free coordinates.

    Args:
        problem: Logs and prior.
        start: Coordinates (n,) to begin with.
        free: Mask (n,) of the coordinates that are fitted.
        on_progress: Called with round and number of rounds.
        scan: Whether dead times far from the start's are tried.
    """
    point, columns = start.copy(), np.flatnonzero(free).tolist()
    prior = problem.space.precision
    noise = noise_of(problem, point)
    for k in range(MAX_NOISE_FITS):
        if on_progress is not None:
            on_progress(k, MAX_NOISE_FITS)
        begin = _scan_dead_time(problem, point, columns, noise, prior) if scan and k == 1 else point
        reached = _gauss_newton(problem, begin, columns, noise, prior)
        still = k > 0 and np.array_equal(reached, point)
        point, noise = reached, noise_of(problem, reached)
        if still:
            break
    return _fit_at(problem, point, free, noise)


def fit_with_noise(problem: Problem, start: Array, free: NDArray[np.bool_], noise: Noise) -> Fit:
    """Fit the free coordinates (n,) from a start (n,) with given noise."""
    columns = np.flatnonzero(free).tolist()
    return _fit_at(problem, _gauss_newton(problem, start, columns, noise, problem.space.precision), free, noise)


def _fit_at(problem: Problem, point: Array, free: NDArray[np.bool_], noise: Noise) -> Fit:
    """Return the fit whose estimate is a point (n,)."""
    residuals, jacobians = problem.sensitivities(point, list(range(len(point))))
    information, scores = _information(problem, residuals, jacobians, noise)
    covariance = _covariance(problem.space, information, _score_covariance(scores, free), free)
    point, covariance = _integrated(problem.space, point, covariance, free)
    covariance += split_covariance(problem.space, point, free)
    return Fit(problem.space, point, free, covariance, information, noise)


def expected_fit(problem: Problem, point: Array, free: NDArray[np.bool_]) -> Fit:
    """Return the expected fit to flights of the vehicle at a point: with the Cramer-Rao covariance."""
    noise = noise_of(problem, point)
    residuals, jacobians = problem.sensitivities(point, list(range(len(point))))
    information, _ = _information(problem, residuals, jacobians, noise)
    covariance = cramer_rao_covariance(problem.space, information, free)
    covariance += split_covariance(problem.space, point, free)
    return Fit(problem.space, point, free, covariance, information, noise)


def cramer_rao_covariance(space: ParameterSpace, information: Array, free: NDArray[np.bool_]) -> Array:
    """Return the Cramer-Rao bound (n, n) of all coordinates for data of an information."""
    return _covariance(space, information, information[np.ix_(free, free)], free)


def noise_of(problem: Problem, point: Array) -> Noise:
    """Fit the noise of every output at a point."""
    residuals = [_summed(part) for part in problem.residuals(point)]
    models = [autoregression([part[:, k] for part in residuals], problem.masks) for k in range(len(OUTPUTS))]
    return Noise(tuple(a for a, _ in models), np.array([innovation_std for _, innovation_std in models]))


def _summed(series: Array) -> Array:
    """Return outputs (m, 4, ...) with changes of rates in leaky sums."""
    return np.concatenate([leaky_sum(series[:, :3]), series[:, 3:]], axis=1)


def _white(problem: Problem, series: Sequence[Array], noise: Noise) -> list[Array]:
    """Return whitened series (m, 4, ...) in innovation standard deviations, 0 where masked."""
    scaled = []
    for part, mask in zip(series, problem.masks, strict=True):
        extra = [1] * (part.ndim - 2)
        weights = np.array(problem.outputs) / noise.innovation_std
        scaled.append(noise.whiten(part) * weights.reshape(-1, *extra) * mask.reshape(-1, 1, *extra))
    return scaled


def _scan_dead_time(problem: Problem, point: Array, columns: list[int], noise: Noise, prior: Array) -> Array:
    """Return the point of least cost over dead times around a point.

    The point itself where the dead time is not fitted.
    """
    names = problem.space.names
    at, period = names.index("dead_time"), min(part.period for part in problem.samples)
    if at not in columns:
        return point
    following = [k for k in columns if names[k] in SCANNED_WITH]
    reached = []
    for shift in SCANNED.tolist():
        moved = point.copy()
        moved[at] += 0.5 * period * shift
        reached.append(_gauss_newton(problem, moved, following, noise, prior, SCAN_ITERATIONS))
    return min(reached, key=lambda entry: _cost(problem, entry, noise, prior))


def _gauss_newton(
    problem: Problem, point: Array, columns: list[int], noise: Noise, prior: Array, iterations: int = MAX_ITERATIONS
) -> Array:
    """Return the point after Gauss-Newton steps, each shortened until the likelihood grows."""
    center, cost = problem.space.center, _cost(problem, point, noise, prior)
    for _ in range(iterations):
        residuals, jacobians = problem.sensitivities(point, columns)
        white, whitened_jacobians = _white(problem, residuals, noise), _white(problem, jacobians, noise)
        j = np.concatenate([part.reshape(-1, len(columns)) for part in whitened_jacobians])
        e = np.concatenate([part.ravel() for part in white])
        prior_precision = prior[np.ix_(columns, columns)]
        hessian = j.T @ j + prior_precision
        step = np.linalg.solve(hessian, j.T @ e - prior_precision @ (point - center)[columns])
        if np.sqrt(step @ hessian @ step) < STEP_TOLERANCE * np.sqrt(len(columns)):
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
    off = point - problem.space.center
    cost = sum(float(np.sum(part**2)) for part in white) + float(off @ prior @ off)
    return cost if np.isfinite(cost) else np.inf


def split_covariance(space: ParameterSpace, point: Array, free: NDArray[np.bool_]) -> Array:
    """Return the covariance (n, n) of the split of the delay.

    Between dead time and gyro, or rotor lags where the gyro's low-pass is known.
    """
    along, numbers = np.zeros(len(point)), space.numbers(point)
    at = {name: space.names.index(name) for name in ("dead_time", "gyro_delay", "lag_up", "lag_down")}
    if not free[at["dead_time"]]:
        return np.outer(along, along)
    along[at["dead_time"]] = SPLIT
    if free[at["gyro_delay"]]:
        along[at["gyro_delay"]] = -min(SPLIT / numbers.gyro_delay, float(space.prior_std[at["gyro_delay"]]))
    else:
        for name, lag in (("lag_up", numbers.lag_up), ("lag_down", numbers.lag_down)):
            along[at[name]] = -SPLIT / lag * free[at[name]]
    return np.outer(along, along)


def _integrated(space: ParameterSpace, point: Array, covariance: Array, free: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Return estimate (n,) and covariance (n, n) with the marginal posteriors of `LINEAR`."""
    for k in (space.names.index(name) for name in LINEAR):
        if free[k]:
            moments = marginal_moments(point[k], covariance[k, k], space.center[k], space.prior_std[k])
            point, covariance = with_moments(point, covariance, k, *moments)
    return point, covariance


def _information(problem: Problem, residuals: list[Array], jacobians: list[Array], noise: Noise) -> tuple[Array, Array]:
    """Return the data's information (n, n), and the scores (blocks, n) of blocks of time."""
    white, whitened_jacobians = _white(problem, residuals, noise), _white(problem, jacobians, noise)
    n = jacobians[0].shape[-1]
    information, scores = np.zeros((n, n)), []
    for part, e, j in zip(problem.samples, white, whitened_jacobians, strict=True):
        information += np.einsum("mka,mkb->ab", j, j)
        rows = np.einsum("mka,mk->ma", j, e)
        width = max(round(BLOCK / (part.period * part.share)), 1)
        scores += [rows[k : k + width].sum(axis=0) for k in range(0, len(rows), width)]
    return information, np.array([row for row in scores if row.any()])


def _score_covariance(scores: Array, free: NDArray[np.bool_]) -> Array:
    """Return the covariance of scores (blocks, n) of the free coordinates: corrected for their degrees of freedom."""
    blocks = len(scores)
    return scores[:, free].T @ scores[:, free] * (blocks / max(blocks - np.count_nonzero(free), 1))


def _covariance(space: ParameterSpace, information: Array, middle: Array, free: NDArray[np.bool_]) -> Array:
    """Return the covariance (n, n) of all coordinates: the information of the data on the free ones, and the prior of the others.

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
