"""Numbers of a fitted plant with 95 % intervals."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.stats import norm, t

from tuner.extensions.plant_fit.estimate import Projection, Search, Solution, covariance_of
from tuner.extensions.plant_fit.response import SampledFilter
from tuner.extensions.plant_fit.selection import Chosen

Array = np.ndarray
LEVEL = 0.975
NORMAL_QUANTILE = float(norm.ppf(LEVEL))
"""Quantile of a normal interval."""
PROFILE = (0.3, 0.6, 1.0, 1.5, 2.0, 2.6, 3.5)
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
    """

    chosen: Chosen
    covariance: Array
    variance: float

    @classmethod
    def of(cls, chosen: Chosen) -> "FittedPlant":
        """Return the plant of a choice."""
        return cls(chosen, *covariance_of(chosen.projection, chosen.solution))

    @property
    def solution(self) -> Solution:
        """The fit."""
        return self.chosen.solution

    @cached_property
    def degrees(self) -> float:
        """Degrees of freedom of the noise power at the plant's corner frequency (Satterthwaite).

        The power of slow noise, on which intervals depend, has fewer degrees of freedom than there are samples.
        """
        solution, count = self.solution, max(len(self.solution.errors) - len(self.covariance), 1)
        p = len(solution.noise)
        corner = max(SampledFilter(each, 1.0).pace for each in solution.denominators) * self.chosen.problem.period
        turns = np.exp(-1j * min(corner, np.pi) * np.arange(1, p + 1))
        gain = 1.0 + solution.noise @ turns
        slopes = -2.0 * np.real(turns / gain)
        of_noise = self.covariance[len(self.covariance) - p :, len(self.covariance) - p :]
        return 2.0 / (2.0 / count + float(slopes @ of_noise @ slopes))

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

    def deviations(self, function: Callable[[Array], Array]) -> tuple[Array, Array]:
        """Return a function of the parameters and its covariance."""
        middle = self.parameters
        steps = SLOPE_STEP * np.maximum(np.sqrt(np.diag(self.covariance)[: self.n_plant]), 1e-12)
        slopes = np.column_stack(
            [
                (function(middle + step * unit) - function(middle - step * unit)) / (2.0 * step)
                for step, unit in zip(steps, np.eye(len(middle)), strict=True)
            ]
        )
        return function(middle), slopes @ self.covariance[: self.n_plant, : self.n_plant] @ slopes.T

    def numbers(self, j: int, units: tuple[str, str] = ("1", "1")) -> list[Number]:
        """Return gain, shape, zeros and dead time of an input; units: of input and output."""
        structure, m = self.solution.structure, len(self.solution.shape)
        deviation = np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        width = float(t.ppf(LEVEL, self.degrees))
        numerator, shape = self.solution.numerators[j], self.solution.shape[j]
        gain = float(deviation[m * (structure.n_shape + structure.has_dead_time) + j * len(numerator)])
        ratio = f"{units[1]}/{units[0]}" + {0: "", 1: "/s", 2: "/s2"}[structure.integrators]
        value = float(numerator[0])
        numbers = [Number("K", value, value - width * gain, value + width * gain, ratio)]
        split = self._time_constants(j, width)
        numbers += split
        for k, (name, unit) in enumerate(structure.names):
            pair = (k - structure.lags) // 2
            if split and pair >= 0 and shape[structure.lags + 2 * pair + 1] > MIN_SPLIT_DAMPING:
                continue
            factor = float(np.exp(min(width * deviation[j * structure.n_shape + k], 50.0)))
            value = float(np.exp(shape[k]))
            numbers.append(Number(name, value, value / factor, value * factor, unit))
        for k in range(1, structure.zeros + 1):

            def zero(parameters: Array, k: int = k) -> Array:
                numerator = self.parts(parameters)[2][j]
                return np.array([numerator[k] / numerator[0]])

            at, covariance = self.deviations(zero)
            value, half = float(at[0]), width * float(np.sqrt(covariance[0, 0]))
            unit = {1: "s", 2: "s2"}[k]
            numbers.append(Number("Tz" if k == 1 else f"Tz{k}", value, value - half, value + half, unit))
        if structure.has_dead_time:
            ends = profile_ends(self, j, float(deviation[m * structure.n_shape + j]))
            numbers.append(Number("L", float(self.solution.dead_times[j]), *ends, "s"))
        return numbers

    def _time_constants(self, j: int, width: float) -> list[Number]:
        """Return the time constants of pairs of real poles."""
        structure, shape = self.solution.structure, self.solution.shape[j]
        numbers = []
        for i in range(structure.lags, structure.n_shape, 2):
            if shape[i + 1] <= MIN_SPLIT_DAMPING:
                continue
            for k, sign in enumerate((1.0, -1.0), 1):

                def logarithm(parameters: Array, i: int = i, sign: float = sign) -> Array:
                    log_w, log_damping = self.parts(parameters)[0][j][i : i + 2]
                    # Times and damping: T = exp(+-acosh(zeta)) / w.
                    return np.array([sign * np.arccosh(np.exp(log_damping)) - log_w])

                at, covariance = self.deviations(logarithm)
                half = min(width * float(np.sqrt(covariance[0, 0])), 50.0)
                tail = f"{(i - structure.lags) // 2 + 1}" if structure.pairs > 1 else ""
                value = float(np.exp(at[0]))
                numbers.append(Number(f"T{tail}{'ab'[k - 1]}", value, value * np.exp(-half), value * np.exp(half), "s"))
        return numbers

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


def profile_ends(plant: FittedPlant, j: int, deviation: float) -> tuple[float, float]:
    """Return the ends of the 95 % interval of a dead time [s]; deviation: by the slopes."""
    problem, solution = plant.chosen.problem, plant.solution
    middle = float(solution.dead_times[j])
    step = max(min(deviation, problem.max_dead_time / 4.0), 1e-3 * problem.period)
    limit = float(t.ppf(LEVEL, plant.degrees) ** 2)
    ends = []
    for sign in (-1.0, 1.0):
        start, end = solution, None
        before = (middle, 0.0)
        for distance in PROFILE:
            at = middle + sign * distance * step
            if at < 0.0 or at > problem.max_dead_time:
                at = 0.0 if at < 0.0 else problem.max_dead_time
            start = _at_dead_time(plant, start, j, at)
            lost = len(solution.errors) * float(np.log(start.cost / solution.cost))
            if lost >= limit:
                # The loss is about a parabola, so its root is nearly straight.
                roots = np.sqrt(max(before[1], 0.0)), np.sqrt(lost)
                end = before[0] + (at - before[0]) * (np.sqrt(limit) - roots[0]) / (roots[1] - roots[0])
                break
            if at in (0.0, problem.max_dead_time):
                end = at
                break
            before = (at, lost)
        ends.append(float(end) if end is not None else float("nan"))
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
