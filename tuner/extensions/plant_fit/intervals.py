"""Numbers of a fitted plant with 95 % intervals."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.stats import norm, t

from tuner.extensions.plant_fit.estimate import Projection, Search, Solution, covariance_of, slopes_of
from tuner.extensions.plant_fit.restricted import RestrictedLikelihood
from tuner.extensions.plant_fit.selection import Chosen

Array = np.ndarray
LEVEL = 0.975
NORMAL_QUANTILE = float(norm.ppf(LEVEL))
"""Quantile of a normal interval."""
PROFILE = (0.5, 1.0, 1.5, 2.0, 2.6, 3.5, 5.0, 8.0)
"""Distances from the estimate, in standard errors, at which the dead time is profiled on either side."""
SLOPE_STEP = 1e-5
MIN_SPLIT_DAMPING = float(np.log(1.5))
"""Logarithm of the damping ratio from which a pair of poles has time constants in tables."""


@dataclass(frozen=True)
class Number:
    """A number of the plant with its 95 % interval; NaN ends: of one that is not identified."""

    name: str
    value: float
    low: float
    high: float
    unit: str

    @property
    def is_identified(self) -> bool:
        """Whether the half-width of the interval is below the number."""
        return bool(np.isfinite(self.low) and np.isfinite(self.high) and self.high - self.low < 2.0 * abs(self.value))


@dataclass(frozen=True)
class FittedPlant:
    """An output's plant: the chosen structure, and its uncertainty.

    Attributes:
        chosen: Structure, fit and rivals.
        covariance: Covariance of shapes, dead times, numerators, offsets and noise, in that order.
        variance: Variance of the prediction errors.
        likelihood: Restricted likelihood of the noise model.
    """

    chosen: Chosen
    covariance: Array
    variance: float
    likelihood: RestrictedLikelihood

    @classmethod
    def of(cls, chosen: Chosen) -> "FittedPlant":
        """Return the plant of a choice."""
        solution = chosen.solution
        slopes = slopes_of(chosen.projection, solution)
        likelihood = RestrictedLikelihood.of(slopes, solution.residuals, len(solution.noise))
        n_outliers = sum(len(each) for each in chosen.problem.outliers)
        return cls(chosen, *covariance_of(solution, slopes, n_outliers), likelihood)

    @property
    def solution(self) -> Solution:
        """The fit."""
        return self.chosen.solution

    @property
    def n_plant(self) -> int:
        """Number of parameters of the plants of all inputs: shapes, dead times, numerators."""
        return len(self.solution.shape) * self.solution.structure.n_free

    @cached_property
    def parameters(self) -> Array:
        """Shapes, dead times and numerators of all inputs."""
        solution = self.solution
        late = solution.dead_times if solution.structure.has_dead_time else np.zeros(0)
        return np.concatenate([solution.shape.ravel(), late, solution.numerators.ravel()])

    def parts(self, parameters: Array) -> tuple[Array, Array, Array]:
        """Return shapes (inputs, n), dead times (inputs,) and numerators (inputs, zeros + 1) of parameters."""
        structure, m = self.solution.structure, len(self.solution.shape)
        n, late = m * structure.n_shape, m * structure.has_dead_time
        dead_times = parameters[n : n + late] if late else np.zeros(m)
        return parameters[:n].reshape(m, -1), dead_times, parameters[n + late :].reshape(m, -1)

    def _slopes(self, function: Callable[[Array], Array]) -> Array:
        middle = self.parameters
        steps = SLOPE_STEP * np.maximum(np.sqrt(np.diag(self.covariance)[: self.n_plant]), 1e-12)
        return np.column_stack(
            [
                (function(middle + step * unit) - function(middle - step * unit)) / (2.0 * step)
                for step, unit in zip(steps, np.eye(len(middle)), strict=True)
            ]
        )

    def deviations(self, function: Callable[[Array], Array]) -> tuple[Array, Array]:
        """Return a function of the parameters and its covariance."""
        slopes = self._slopes(function)
        return function(self.parameters), slopes @ self.covariance[: self.n_plant, : self.n_plant] @ slopes.T

    def spread(self, function: Callable[[Array], float]) -> tuple[float, float]:
        """Return the standard deviation of a function of the parameters, and the quantile of its 95 % interval."""
        slopes = self._slopes(lambda parameters: np.array([function(parameters)]))[0]
        variance = float(slopes @ self.covariance[: self.n_plant, : self.n_plant] @ slopes)
        degrees = self.likelihood.degrees_of(slopes, self.solution.noise)
        return float(np.sqrt(max(variance, 0.0))), float(t.ppf(LEVEL, degrees))

    def numbers(self, j: int, units: tuple[str, str] = ("1", "1")) -> list[Number]:
        """Return gain, shape, zeros and dead time of an input; units: of input and output."""
        structure = self.solution.structure
        ratio = f"{units[1]}/{units[0]}" + {0: "", 1: "/s", 2: "/s2"}[structure.integrators]
        numbers = [self._number("K", ratio, lambda parameters: self.parts(parameters)[2][j, 0])]
        numbers += [self._positive(name, unit, logarithm) for name, unit, logarithm in self._shape_numbers(j)]
        for k in range(1, structure.zeros + 1):

            def zero(parameters: Array, k: int = k) -> float:
                numerator = self.parts(parameters)[2][j]
                return float(numerator[k] / numerator[0])

            numbers.append(self._number("Tz" if k == 1 else f"Tz{k}", {1: "s", 2: "s2"}[k], zero))
        if structure.has_dead_time:
            ends = profile_ends(self, j, *self.spread(lambda parameters: self.parts(parameters)[1][j]))
            numbers.append(Number("L", float(self.solution.dead_times[j]), *ends, "s"))
        return numbers

    def _number(self, name: str, unit: str, function: Callable[[Array], float]) -> Number:
        value, half = float(function(self.parameters)), float(np.prod(self.spread(function)))
        return Number(name, value, value - half, value + half, unit)

    def _positive(self, name: str, unit: str, logarithm: Callable[[Array], float]) -> Number:
        value, factor = np.exp(logarithm(self.parameters)), np.exp(min(np.prod(self.spread(logarithm)), 50.0))
        return Number(name, float(value), float(value / factor), float(value * factor), unit)

    def _shape_numbers(self, j: int) -> Iterator[tuple[str, str, Callable[[Array], float]]]:
        """Yield name, unit and logarithm of each positive number; pairs of real poles have time constants."""
        structure, shape = self.solution.structure, self.solution.shape[j]
        for k, (name, unit) in enumerate(structure.names):
            first = k - (k - structure.lags) % 2
            if k < structure.lags or shape[first + 1] <= MIN_SPLIT_DAMPING:
                yield name, unit, lambda parameters, k=k: self.parts(parameters)[0][j, k]
                continue
            tail, sign = name.lstrip("wzeta"), 1.0 if k == first else -1.0

            def logarithm(parameters: Array, first: int = first, sign: float = sign) -> float:
                log_w, log_damping = self.parts(parameters)[0][j, first : first + 2]
                # Times and damping: T = exp(+-acosh(zeta)) / w.
                return float(sign * np.arccosh(np.exp(log_damping)) - log_w)

            yield f"T{tail}{'a' if k == first else 'b'}", "s", logarithm

    def coefficients(self, j: int, parameters: Array | None = None) -> tuple[Array, Array]:
        """Return numerator and denominator, from the highest power of s."""
        shapes, _, numerators = self.parts(self.parameters if parameters is None else parameters)
        return numerators[j][::-1], self.solution.structure.denominator(shapes[j])

    def response(self, j: int, frequency: Array) -> tuple[Array, Array, Array]:
        """Return log magnitude, phase [rad] and their deviations (2, k)."""

        def log_response(parameters: Array) -> Array:
            numerator, denominator = self.coefficients(j, parameters)
            late = self.parts(parameters)[1][j]
            s = 1j * frequency
            # Logarithms of factors, so that phases do not jump by a turn.
            ratio = np.polyval(numerator, s) / np.polyval(denominator, s)
            angle = np.unwrap(np.angle(ratio)) - frequency * late
            return np.concatenate([np.log(np.abs(ratio)), angle])

        value, covariance = self.deviations(log_response)
        spread = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        k = len(frequency)
        return value.reshape(2, k)[0], value.reshape(2, k)[1], spread.reshape(2, k)


def profile_ends(plant: FittedPlant, j: int, deviation: float, quantile: float) -> tuple[float, float]:
    """Return the ends of the 95 % interval of a dead time [s].

    Args:
        plant: Plant of an output.
        j: Index of the input.
        deviation: Standard deviation by the slopes.
        quantile: Quantile of Student's t.
    """
    problem, solution = plant.chosen.problem, plant.solution
    middle, top = float(solution.dead_times[j]), problem.max_dead_time
    step = max(min(deviation, top / 4.0), 1e-3 * problem.period)
    ends = []
    for sign in (-1.0, 1.0):
        start, before, end = solution, (middle, 0.0), float("nan")
        for distance in PROFILE:
            at = float(np.clip(middle + sign * distance * step, 0.0, top))
            start = _at_dead_time(plant, start, j, at)
            # The loss is about a parabola, so its root is nearly straight.
            lost = float(np.sqrt(max(len(solution.errors) * np.log(start.cost / solution.cost), 0.0)))
            if lost >= quantile:
                end = before[0] + (at - before[0]) * (quantile - before[1]) / (lost - before[1])
                break
            if at in (0.0, top):
                end = at
                break
            before = (at, lost)
        ends.append(end)
    return ends[0], ends[1]


def _at_dead_time(plant: FittedPlant, start: Solution, j: int, dead_time: float) -> Solution:
    """Return the best fit with a dead time; those of other inputs are as fitted."""
    dead_times = start.dead_times.copy()
    dead_times[j] = dead_time
    fixed = replace(start.structure, has_dead_time=False)
    projection = Projection(plant.chosen.problem, fixed, dead_times)
    first = projection.solve(start.shape, dead_times, start.noise)
    best = Search(projection).polish(first, evaluations=8)
    return replace(best, structure=start.structure, dead_times=dead_times)
