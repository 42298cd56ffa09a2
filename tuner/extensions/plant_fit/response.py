"""Responses of a structure to measured inputs: exact for inputs that are held between equally spaced samples.

Of samples that are not equally spaced, the model is stepped on a finer grid: a cell of the grid has the mean input over it,
and the output at a sample is interpolated.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial.legendre import legvander
from scipy.signal import lfilter

from tuner.extensions.plant_fit.reading import Experiment

Array = np.ndarray
N_TERMS = 14
"""Terms of the exponential of a matrix whose norm is at most 0.5: the next is below 1e-17."""
FINER = 4
"""Cells of the grid in a median sampling interval of irregular samples."""


@dataclass(frozen=True)
class Grid:
    """Inputs of an experiment on equally spaced cells.

    Attributes:
        period: Length of a cell [s].
        inputs: Deviation (cells, inputs) of each input from its value before the record.
        place: Sampling times in cells (samples,), None where each cell begins with a sample.
    """

    period: float
    inputs: Array
    place: Array | None

    @classmethod
    def of(cls, experiment: Experiment) -> "Grid":
        """Return the grid of an experiment."""
        deviation = experiment.inputs - experiment.before
        if experiment.is_regular:
            return cls(experiment.period, deviation, None)
        time = experiment.time - experiment.time[0]
        period = float(np.median(np.diff(time))) / FINER
        edges = period * np.arange(int(np.ceil(time[-1] / period)) + 2)
        integral = np.vstack([np.zeros(deviation.shape[1]), np.cumsum(deviation[:-1] * np.diff(time)[:, None], axis=0)])
        columns = [np.diff(np.interp(edges, time, column)) / period for column in integral.T]
        return cls(period, np.column_stack(columns), time / period)

    def thinned(self, every: int) -> "Grid":
        """Return the grid of every n-th sample, n = every."""
        missing = -len(self.inputs) % every
        padded = np.concatenate([self.inputs, np.repeat(self.inputs[-1:], missing, axis=0)])
        means = padded.reshape(-1, every, self.inputs.shape[1]).mean(axis=1)
        return Grid(self.period * every, means, None if self.place is None else self.place[::every] / every)

    @property
    def relative_time(self) -> Array:
        """Sampling times (samples,) over the record, from -1 to 1."""
        place = np.arange(len(self.inputs)) if self.place is None else self.place
        return 2.0 * place / place[-1] - 1.0

    def at_samples(self, series: Array) -> Array:
        """Return a series of the grid (cells,) at the samples."""
        if self.place is None:
            return series
        return np.interp(self.place, np.arange(len(series)), series)


def exponential(matrix: Array) -> Array:
    """Return the exponential of a small square matrix."""
    # SciPy's routine solves with a threaded library: where other work takes the processors, that waits 25 ms for 4 rows.
    halvings = max(0, int(np.ceil(np.log2(max(float(np.abs(matrix).sum(axis=1).max()), 1e-300)))) + 1)
    part, term = matrix / 2.0**halvings, np.eye(len(matrix))
    total = term.copy()
    for k in range(1, N_TERMS + 1):
        term = term @ part / k
        total += term
    for _ in range(halvings):
        total = total @ total
    return total


class SampledFilter:
    """A denominator sampled on a grid: its responses are the filtered input and its derivatives.

    Phase variables x_k = s^k / d(s) u in a unit of time in which the poles are about 1, so that they are of one size.
    """

    def __init__(self, denominator: Array, period: float) -> None:
        n = len(denominator) - 1
        monic = denominator / denominator[0]
        nonzero = np.flatnonzero(monic)
        self.pace = float(abs(monic[nonzero[-1]]) ** (1.0 / nonzero[-1])) if nonzero[-1] else 1.0 / period
        self.order, self.period, self._lead = n, period, denominator[0] * self.pace**n
        scaled = monic / self.pace ** np.arange(n + 1)
        matrix = np.zeros((n + 1, n + 1))
        matrix[: n - 1, 1:n] = np.eye(n - 1)
        matrix[n - 1, :n] = -scaled[:0:-1]
        matrix[n - 1, n] = 1.0
        self._generator = matrix * self.pace * period
        self._transition = exponential(self._generator)
        self.step = self._transition[:n, :n]
        self.poles = np.real(np.poly(np.linalg.eigvals(self.step)))

    def responses(self, inputs: Array, dead_time: float, n_responses: int) -> list[Array]:
        """Return s^k / d(s) of an input (cells,) behind a dead time [s]."""
        shift, rest = divmod(dead_time / self.period, 1.0)
        k = min(int(shift), len(inputs))
        delayed = np.concatenate([np.zeros(k), inputs[: len(inputs) - k]])
        rows = self._numerators(rest)[:n_responses]
        scale = self.pace ** np.arange(n_responses) / self._lead
        return [np.asarray(lfilter(row * factor, self.poles, delayed)) for row, factor in zip(rows, scale, strict=True)]

    def _numerators(self, rest: float) -> Array:
        """Return the numerators (order, order + 2) of the phase variables; rest: part of a cell by which the input is late."""
        n = self.order
        early = (self._transition if rest == 0.0 else exponential(self._generator * (1.0 - rest)))[:n, n]
        late = self._transition[:n, n] - early
        markov = np.zeros((n, n + 2))
        for vector, first in ((early, 1), (late, 2)):
            for i in range(first, n + 2):
                markov[:, i] += vector
                vector = self.step @ vector
        return np.array([np.convolve(row, self.poles)[: n + 2] for row in markov])

    def free_responses(self, n_cells: int) -> list[Array]:
        """Return a basis of the responses (cells,) to initial states."""
        starts = np.zeros((self.order, n_cells))
        np.fill_diagonal(starts, 1.0)
        return [np.asarray(lfilter([1.0], self.poles, start)) for start in starts]


@dataclass(frozen=True)
class Regressors:
    """Columns that enter an output linearly.

    Attributes:
        grids: Grid of each experiment.
        has_start: Whether initial states are estimated, for each experiment.
        drift_degree: Degree of the drift, a polynomial of time; 0 without one.
    """

    grids: tuple[Grid, ...]
    has_start: tuple[bool, ...]
    drift_degree: int

    def matrices(self, filters: list[tuple[Array, int]], dead_times: Array) -> list[Array]:
        """Return the columns of each experiment (samples, columns): first those of the inputs, which all experiments share.

        Args:
            filters: Denominator and number of numerator coefficients of each input.
            dead_times: Dead time of each input [s].
        """
        return [self._matrix(i, filters, dead_times) for i in range(len(self.grids))]

    def _matrix(self, i: int, filters: list[tuple[Array, int]], dead_times: Array) -> Array:
        grid = self.grids[i]
        columns: list[Array] = []
        free: list[Array] = []
        for j, (denominator, n_numerator) in enumerate(filters):
            sampled = SampledFilter(denominator, grid.period)
            columns += sampled.responses(grid.inputs[:, j], dead_times[j], n_numerator)
            if self.has_start[i]:
                free += sampled.free_responses(len(grid.inputs))
                # What entered the dead time before the record is taken for constant.
                free += sampled.responses(np.ones(len(grid.inputs)), dead_times[j], 1)
        sampled_columns = [grid.at_samples(each) for each in columns + free]
        n_driven = len(columns)
        return np.column_stack([*sampled_columns[:n_driven], self._drifts[i], *sampled_columns[n_driven:]])

    @cached_property
    def _drifts(self) -> list[Array]:
        """Offset and drift of each experiment (samples, drift_degree + 1)."""
        return [legvander(grid.relative_time, self.drift_degree) for grid in self.grids]
