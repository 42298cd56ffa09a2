"""Numbers of a fitted plant with 95 % intervals."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.stats import norm, t

from tuner.extensions.plant_fit.curvature import Curvature, bends_of
from tuner.extensions.plant_fit.estimate import Search, Solution
from tuner.extensions.plant_fit.restricted import RestrictedLikelihood
from tuner.extensions.plant_fit.selection import Chosen
from tuner.extensions.plant_fit.slopes import MIN_INFORMATION, covariance_of, jacobian_of, slopes_of

Array = np.ndarray
LEVEL = 0.975
NORMAL_QUANTILE = float(norm.ppf(LEVEL))
"""Quantile of a normal interval."""
MIN_PROFILE_WIDTH = 0.05
MAX_PROFILE_WIDTH = 3.0
"""Half-widths of the logarithm of a number between which its interval is a likelihood profile.

A narrower one is symmetric, and a number with a wider one is not identified.
"""
MIN_DEVIATION = 1e-7
"""Relative standard deviation below which a record counts as free of noise."""
PULL_WEIGHT, MAX_TRIALS, TRIAL_EVALUATIONS, MAX_OVERSHOOT = 3.0, 6, 8, 1.3
SLOPE_STEP = 1e-5
MAX_CORRECTION = 1.5
"""Largest mean loss that intervals are corrected by: more is beyond two terms of a series."""
MAX_HIDDEN_SHARE = 0.1
"""Share of a number's slope in directions that the data do not show, from which it has no interval."""
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
class Spread:
    """Uncertainty of a number.

    Attributes:
        deviation: Standard deviation.
        of_plant: Standard deviation if the noise model were known.
        quantile: Quantile of Student's t for a 95 % interval.
    """

    deviation: float
    of_plant: float
    quantile: float

    @property
    def half_width(self) -> float:
        """Half-width of the symmetric interval."""
        return self.quantile * self.deviation


@dataclass(frozen=True)
class FittedPlant:
    """An output's plant: the chosen structure, and its uncertainty.

    Attributes:
        chosen: Structure, fit and rivals.
        covariance: Covariance of shapes, dead times, numerators, offsets and noise, in that order.
        variance: Variance of the prediction errors.
        likelihood: Restricted likelihood of the noise model.
        jacobian: Slopes of the prediction errors to these parameters (samples, k).
    """

    chosen: Chosen
    covariance: Array
    variance: float
    likelihood: RestrictedLikelihood
    jacobian: Array

    @classmethod
    def of(cls, chosen: Chosen) -> "FittedPlant":
        """Return the plant of a choice."""
        solution = chosen.solution
        slopes = slopes_of(chosen.projection, solution)
        likelihood = RestrictedLikelihood.of(slopes, solution.residuals, len(solution.noise))
        n_outliers = sum(len(each) for each in chosen.problem.outliers)
        jacobian = jacobian_of(solution, slopes)
        return cls(chosen, *covariance_of(solution, jacobian, n_outliers), likelihood, jacobian)

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
        return self.parameters_of(self.solution)

    def parameters_of(self, solution: Solution) -> Array:
        """Return shapes, dead times and numerators of a fit."""
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

    @cached_property
    def covariance_alone(self) -> Array:
        """Covariance of the plant's parameters if the noise model were known."""
        n, p = self.n_plant, len(self.solution.noise)
        cross, of_noise = (
            self.covariance[:n, len(self.covariance) - p :],
            self.covariance[len(self.covariance) - p :][:, -p:],
        )
        return self.covariance[:n, :n] - (cross @ np.linalg.pinv(of_noise) @ cross.T if p else 0.0)

    @cached_property
    def _hidden(self) -> tuple[Array, Array]:
        """Sizes of slopes, and directions (n, directions) in their units without information."""
        size = np.linalg.norm(self.jacobian, axis=0)
        size[size == 0.0] = 1.0
        _, values, turned = np.linalg.svd(np.linalg.qr(self.jacobian / size, mode="r"))
        return size[: self.n_plant], turned[values < MIN_INFORMATION * values[0], : self.n_plant].T

    def spread(self, function: Callable[[Array], float]) -> "Spread":
        """Return the uncertainty of a function of the parameters.

        It is infinite for a function that the data do not show.
        """
        slopes = self._slopes(lambda parameters: np.array([function(parameters)]))[0]
        n = self.n_plant
        size, hidden = self._hidden
        # The covariance leaves these directions out: a pole far above the sampling rate would get a narrow interval.
        if np.linalg.norm((slopes / size) @ hidden) > MAX_HIDDEN_SHARE * np.linalg.norm(slopes / size):
            return Spread(np.inf, np.inf, NORMAL_QUANTILE)
        both, alone = (float(slopes @ each @ slopes) for each in (self.covariance[:n, :n], self.covariance_alone))
        degrees = self.likelihood.degrees_of(slopes, self.solution.noise)
        deviation, of_plant = (float(np.sqrt(max(each, 0.0))) for each in (both, alone))
        return Spread(deviation, of_plant, float(t.ppf(LEVEL, degrees)))

    @cached_property
    def curvature(self) -> Curvature:
        """Second derivatives of the responses at the fit."""
        return Curvature.of(self.chosen.projection, self.solution, self.jacobian, self.variance)

    def correction(self, function: Callable[[Array], float]) -> float:
        """Return Bartlett's correction of the loss that a function's interval allows."""
        deviations = np.sqrt(np.diag(self.covariance)[: self.n_plant])
        mean = self.curvature.mean_loss(*bends_of(function, self.parameters, deviations))
        return float(np.sqrt(np.clip(mean, 1.0, MAX_CORRECTION)))

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
            numbers.append(Number("L", float(self.solution.dead_times[j]), *self.dead_time_ends[j], "s"))
        return numbers

    @cached_property
    def dead_time_ends(self) -> list[tuple[float, float]]:
        """Ends of the 95 % interval of each input's dead time [s]."""
        inputs = range(len(self.solution.shape))
        return [profile_ends(self, lambda parameters, j=j: float(self.parts(parameters)[1][j])) for j in inputs]

    def _number(self, name: str, unit: str, function: Callable[[Array], float]) -> Number:
        value, half = float(function(self.parameters)), self.spread(function).half_width
        half = half if np.isfinite(half) else np.nan
        return Number(name, value, value - half, value + half, unit)

    def _positive(self, name: str, unit: str, logarithm: Callable[[Array], float]) -> Number:
        value, half = logarithm(self.parameters), self.spread(logarithm).half_width
        half = half if np.isfinite(half) else np.nan
        is_curved = MIN_PROFILE_WIDTH < half < MAX_PROFILE_WIDTH
        low, high = profile_ends(self, logarithm) if is_curved else (value - half, value + half)
        low, value, high = (float(np.exp(np.minimum(each, 50.0))) for each in (low, value, high))
        return Number(name, value, low, high, unit)

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
                return float(sign * np.arccosh(np.exp(max(log_damping, 0.0))) - log_w)

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


def profile_ends(plant: FittedPlant, number: Callable[[Array], float]) -> tuple[float, float]:
    """Return the ends of the likelihood profile of a number.

    NaN is an end that no trial reaches. The other parameters are fitted again under a pull of the number to each trial value:
    that leads to points of the profile.
    """
    solution, spread = plant.solution, plant.spread(number)
    middle, shift = number(plant.parameters), spread.half_width
    if not np.isfinite(shift):
        return float("nan"), float("nan")
    if spread.of_plant <= MIN_DEVIATION * max(abs(middle), plant.chosen.problem.period):
        return middle - shift, middle + shift
    # The noise model stays, so losses count by the deviation that they would have if it were known.
    wanted = spread.quantile * spread.deviation / spread.of_plant * plant.correction(number)
    weight = PULL_WEIGHT * float(np.sqrt(plant.variance)) / spread.of_plant
    ends = []
    for sign in (-1.0, 1.0):
        start, before, end, target = solution, (middle, 0.0), float("nan"), middle + sign * shift
        for _ in range(MAX_TRIALS):

            def pull(parameters: Array, target: float = target) -> float:
                return weight * (number(parameters) - target)

            start = Search(plant.chosen.projection).polish(start, evaluations=TRIAL_EVALUATIONS, pull=pull)
            at = number(plant.parameters_of(start))
            lost = float(np.sqrt(max(start.cost - solution.cost, 0.0) / plant.variance))
            if lost >= wanted:
                # The loss is about a parabola, so its root is nearly straight.
                end = before[0] + (at - before[0]) * (wanted - before[1]) / (lost - before[1])
                if lost <= MAX_OVERSHOOT * wanted:
                    break
                start, target = solution, end + sign * 0.1 * abs(end - middle)
                continue
            if abs(target - at) > 0.5 * abs(target - before[0]):
                # It does not follow: it is at the end of its range.
                end = at
                break
            before = (at, lost)
            target = middle + (at - middle) * float(np.clip(1.2 * wanted / max(lost, 1e-9), 1.3, 3.0))
        ends.append(float(end))
    return ends[0], ends[1]
