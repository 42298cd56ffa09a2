"""Parameters that minimise the prediction errors.

Numerators, offsets, drift and initial states enter linearly: for given shape parameters, dead times and noise model they follow
from least squares (variable projection, Golub and Pereyra), so that a search has few dimensions. The dead time enters by its
steps of the sampled input, along which the error has kinks: the search starts from the best of a grid.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product

import numpy as np
from scipy.optimize import least_squares

from tuner.extensions.plant_fit.noise import fill_outliers, whiten
from tuner.extensions.plant_fit.reading import Experiment
from tuner.extensions.plant_fit.response import Grid, Regressors
from tuner.extensions.plant_fit.structures import Structure

Array = np.ndarray
RIDGE = 1e-13
"""Share of each normal equation's diagonal that keeps columns apart which are alike, such as an offset and a free integrator."""
N_DEAD_TIMES, N_SLOW, N_STARTS = 12, 6, 2
MAX_EVALUATIONS, FIRST_EVALUATIONS = 30, 8
MIN_SLOPE = 1e-11
"""Slope of half the sum of squares, over that of the outputs, at which a search ends."""
FILLINGS = 2
"""Times that outliers are filled in again."""
AT_REST = 5
"""Samples at the beginning of a record that all differ in their inputs if it does not begin at rest."""
REDUCED = 1500
"""Samples to which the record of a first search is thinned out."""


@dataclass(frozen=True)
class Problem:
    """An output of experiments to be explained.

    Attributes:
        grids: Inputs of each experiment.
        outputs: Output of each experiment (samples,).
        outliers: Places of outliers in each experiment.
        has_start: Whether the initial state of each experiment is estimated.
        has_trend: Whether a straight drift is estimated.
        max_dead_time: Largest dead time [s].
        rows: Samples of each experiment that count, None for all.
    """

    grids: tuple[Grid, ...]
    outputs: tuple[Array, ...]
    outliers: tuple[Array, ...]
    has_start: tuple[bool, ...]
    has_trend: bool
    max_dead_time: float
    rows: tuple[Array, ...] | None = None

    @classmethod
    def of(cls, experiments: list[Experiment], output: int, max_dead_time: float | None, has_trend: bool) -> "Problem":
        """Return the problem of one output of experiments."""
        span = max(each.time[-1] - each.time[0] for each in experiments)
        # An input that moves from its first sample on, as under feedback, has no rest before it.
        is_moving = [len(np.unique(each.inputs[:AT_REST], axis=0)) == AT_REST for each in experiments]
        return cls(
            tuple(Grid.of(each) for each in experiments),
            tuple(each.outputs[:, output] for each in experiments),
            tuple(np.zeros(0, dtype=int) for _ in experiments),
            tuple(is_moving),
            has_trend,
            span / 5.0 if max_dead_time is None else max_dead_time,
        )

    def thinned(self, every: int) -> "Problem":
        """Return the problem of every n-th sample, n = every."""
        return replace(
            self,
            grids=tuple(grid.thinned(every) for grid in self.grids),
            outputs=tuple(each[::every] for each in self.outputs),
            outliers=tuple(each[each % every == 0] // every for each in self.outliers),
        )

    @property
    def n_inputs(self) -> int:
        """Number of inputs."""
        return self.grids[0].inputs.shape[1]

    @property
    def n_samples(self) -> int:
        """Number of samples of all experiments."""
        return sum(len(each) for each in self.outputs)

    @cached_property
    def size(self) -> float:
        """Norm of the outputs from their means."""
        return float(np.sqrt(sum(np.sum((each - each.mean()) ** 2) for each in self.outputs)))

    @property
    def period(self) -> float:
        """Length of a cell of the shortest grid [s]."""
        return min(grid.period for grid in self.grids)

    @property
    def span(self) -> float:
        """Duration of the longest experiment [s]."""
        return max(grid.period * len(grid.inputs) for grid in self.grids)


@dataclass(frozen=True)
class Solution:
    """A structure fitted to a problem.

    Attributes:
        structure: Structure of every input's transfer function.
        shape: Shape parameters (inputs, n).
        dead_times: Dead time of each input [s].
        noise: Coefficients (p,) of the noise model.
        linear: Numerators of all inputs, then offsets, drift and initial states of each experiment.
        errors: Prediction errors of all counted samples.
        residuals: Output without the plant's for each experiment (samples,), outliers filled in.
    """

    structure: Structure
    shape: Array
    dead_times: Array
    noise: Array
    linear: Array
    errors: Array = field(repr=False)
    residuals: tuple[Array, ...] = field(repr=False)

    @property
    def cost(self) -> float:
        """Sum of squared prediction errors."""
        return float(self.errors @ self.errors)

    @property
    def numerators(self) -> Array:
        """Coefficients (inputs, zeros + 1) of the numerators, from the lowest power of s."""
        m, k = len(self.shape), self.structure.zeros + 1
        return self.linear[: m * k].reshape(m, k)

    @property
    def denominators(self) -> list[Array]:
        """Denominator of each input, from the highest power of s."""
        return [self.structure.denominator(each) for each in self.shape]


class Projection:
    """Linear parameters of a problem, given all others."""

    def __init__(self, problem: Problem, structure: Structure) -> None:
        self.problem, self.structure = problem, structure
        # An input's unknown value at rest makes a ramp behind an integrator, and a parabola behind two.
        degree = max(int(problem.has_trend), structure.integrators)
        self._regressors = Regressors(problem.grids, problem.has_start, degree)

    def matrices(self, shape: Array, dead_times: Array) -> list[Array]:
        """Return the columns (samples, linear parameters) of each experiment."""
        count = self.structure.zeros + 1
        parts = self._regressors.matrices([(self.structure.denominator(row), count) for row in shape], dead_times)
        shared = count * self.problem.n_inputs
        n_offsets = [part.shape[1] - shared for part in parts]
        wide = []
        for i, part in enumerate(parts):
            left, right = np.zeros((len(part), sum(n_offsets[:i]))), np.zeros((len(part), sum(n_offsets[i + 1 :])))
            wide.append(np.hstack([part[:, :shared], left, part[:, shared:], right]))
        return wide

    def solve(self, shape: Array, dead_times: Array, noise: Array) -> Solution:
        """Return the solution; outliers have the values that the noise model expects."""
        problem = self.problem
        shape = shape.reshape(problem.n_inputs, self.structure.n_shape)
        matrices = self.matrices(shape, dead_times)
        outputs = list(problem.outputs)
        has_outliers = any(len(each) for each in problem.outliers)
        linear, errors = self._least_squares(matrices, outputs, noise)
        residuals = [y - x @ linear for x, y in zip(matrices, outputs, strict=True)]
        for _ in range(FILLINGS if has_outliers else 0):
            filled = map(fill_outliers, residuals, problem.outliers, [noise] * len(residuals))
            outputs = [x @ linear + each for x, each in zip(matrices, filled, strict=True)]
            linear, errors = self._least_squares(matrices, outputs, noise)
            residuals = [y - x @ linear for x, y in zip(matrices, outputs, strict=True)]
        return Solution(self.structure, shape, np.array(dead_times), noise, linear, errors, tuple(residuals))

    def _least_squares(self, matrices: list[Array], outputs: list[Array], noise: Array) -> tuple[Array, Array]:
        x = np.vstack([whiten(each, noise) for each in matrices])
        y = np.concatenate([whiten(each, noise) for each in outputs])
        chosen = x if self.problem.rows is None else x[self.counted(noise)]
        wanted = y if self.problem.rows is None else y[self.counted(noise)]
        linear = solve_normal(chosen, wanted)
        return linear, y - x @ linear

    def counted(self, noise: Array) -> Array:
        """Return a mask of the prediction errors that count."""
        assert self.problem.rows is not None
        return np.concatenate([rows[len(noise) :] for rows in self.problem.rows])


def simulated(projection: Projection, solution: Solution) -> list[Array]:
    """Return simulated outputs (samples,) with the best offsets and initial states.

    Under noise that wanders, those of the prediction errors can be far from the record.
    """
    shared = solution.numerators.size
    matrices = projection.matrices(solution.shape, solution.dead_times)
    driven = [each[:, :shared] @ solution.linear[:shared] for each in matrices]
    outputs = projection.problem.outputs
    left = np.concatenate([y - each for y, each in zip(outputs, driven, strict=True)])
    offsets = solve_normal(np.vstack([each[:, shared:] for each in matrices]), left)
    return [each + matrix[:, shared:] @ offsets for each, matrix in zip(driven, matrices, strict=True)]


def share(projection: Projection, solution: Solution) -> float:
    """Return the fit to all of the record [1]: 1 - |y - model| / |y - mean|."""
    outputs = projection.problem.outputs
    pairs = zip(outputs, simulated(projection, solution), strict=True)
    left = sum(float(np.sum((y - each) ** 2)) for y, each in pairs)
    moved = sum(float(np.sum((each - each.mean()) ** 2)) for each in outputs)
    return 1.0 - float(np.sqrt(left / moved))


def solve_normal(x: Array, y: Array) -> Array:
    """Return the least-squares solution by normal equations with one correction."""
    size = np.sqrt(np.einsum("ij,ij->j", x, x))
    size[size == 0.0] = 1.0
    scaled = x / size
    normal = scaled.T @ scaled + RIDGE * len(size) * np.eye(len(size))
    solution = np.linalg.solve(normal, scaled.T @ y)
    solution += np.linalg.solve(normal, scaled.T @ (y - scaled @ solution))
    return solution / size


@dataclass(frozen=True)
class Search:
    """A search for the shape parameters and dead times of a structure."""

    projection: Projection

    @property
    def _ends(self) -> tuple[Array, Array]:
        problem, structure = self.projection.problem, self.projection.structure
        low, high = structure.bounds(problem.period / 10.0, 20.0 * problem.span)
        m, late = problem.n_inputs, 1 if structure.has_dead_time else 0
        return (
            np.concatenate([np.tile(low, m), np.zeros(late * m)]),
            np.concatenate([np.tile(high, m), np.full(late * m, max(problem.max_dead_time, 1e-9))]),
        )

    def polish(
        self, start: Solution, evaluations: int = MAX_EVALUATIONS, pull: Callable[[Array], float] | None = None
    ) -> Solution:
        """Return the solution at the minimum next to a start.

        The noise model stays.

        Args:
            start: Fit to begin with.
            evaluations: Most steps.
            pull: Further error, a function of shapes and dead times.
        """
        problem, structure = self.projection.problem, self.projection.structure
        m, n = problem.n_inputs, structure.n_shape * problem.n_inputs
        late = m if structure.has_dead_time else 0
        # Dead times are counted in cells, so that all parameters are of one size.
        scale = np.concatenate([np.ones(n), np.full(late, problem.period)])
        first = np.concatenate([start.shape.ravel(), start.dead_times[:late]]) / scale
        low, high = (ends / scale for ends in self._ends)

        def solved(x: Array) -> Solution:
            x = x * scale
            return self.projection.solve(x[:n], x[n:] if late else np.zeros(m), start.noise)

        def errors(x: Array) -> Array:
            solution = solved(x)
            counted = slice(None) if problem.rows is None else self.projection.counted(solution.noise)
            # The search's bound on slopes is absolute: in units in which outputs are small, every start would satisfy it.
            return np.append(solution.errors[counted], [] if pull is None else pull(x * scale)) / problem.size

        if len(first) == 0:
            return solved(first)
        margin = 1e-6 * np.minimum(1.0, high - low)
        minimum = least_squares(
            errors,
            np.clip(first, low + margin, high - margin),
            bounds=(low, high),
            diff_step=np.where(np.arange(len(first)) < n, 1e-5, 1e-4),
            max_nfev=evaluations,
            xtol=1e-6,
            ftol=1e-9,
            gtol=MIN_SLOPE,
        )
        return solved(minimum.x)

    def from_grid(self, noise: Array, shapes: list[Array], dead_times: Array) -> Solution:
        """Return the best solution from starting shapes (n_shape,) and dead times [s]."""
        problem, structure = self.projection.problem, self.projection.structure
        m = problem.n_inputs
        late = dead_times if structure.has_dead_time else np.zeros(1)
        starts = [
            self.projection.solve(np.tile(shape, m), np.full(m, dead_time), noise)
            for shape, dead_time in product(shapes, late)
        ]
        starts.sort(key=lambda each: each.cost)
        best: list[Solution] = []
        for start in starts:
            if all(self._differ(start, each) for each in best):
                best.append(start)
            if len(best) == N_STARTS + (structure.zeros > 0):
                break
        polished = [self.polish(start, evaluations=FIRST_EVALUATIONS) for start in best]
        return min(polished, key=lambda each: each.cost)

    def _differ(self, one: Solution, other: Solution) -> bool:
        """Whether two starts may lead to different minima: a zero in the right half-plane replaces a dead time."""
        shapes = np.abs(one.shape - other.shape).max(initial=0.0) > 0.3
        late = np.abs(one.dead_times - other.dead_times).max() > 0.3 * max(one.dead_times.max(), other.dead_times.max())
        return bool(shapes or (self.projection.structure.zeros > 0 and late))


def usual_dead_times(problem: Problem) -> Array:
    """Return the dead times that a search begins with [s]."""
    top = problem.max_dead_time / problem.period
    cells = np.unique(np.round(np.concatenate([[0.0], np.geomspace(1.0, max(top, 1.0), N_DEAD_TIMES)])))
    return np.minimum(problem.period * cells, problem.max_dead_time)


def starts_of(structure: Structure, problem: Problem, earlier: Solution | None) -> list[Array]:
    """Return shapes (n_shape,) to begin with; earlier: of a simpler structure."""
    slow = np.linspace(np.log(problem.period) + 0.5, np.log(problem.span), N_SLOW)
    if structure.n_shape == 0:
        return [np.zeros(0)]
    if structure.n_shape == 1:
        return [np.array([each]) for each in slow]
    dampings = np.log([0.1, 0.5, 1.2])
    if structure.n_shape == 2:
        return [np.array([-each, damping]) for each in slow for damping in dampings]
    shape = np.zeros(0) if earlier is None else np.median(earlier.shape, axis=0)
    if structure.lags == 1:
        return [np.concatenate([[each], shape[-2:]]) for each in slow]
    return [np.concatenate([shape[-2:], [-each, damping]]) for each in slow for damping in dampings[:2]]
