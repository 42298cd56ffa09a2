"""Fitted plants as the numbers of [plant]: a transfer function, or a state space of all pairs of inputs and outputs."""

from collections.abc import Sequence

import numpy as np

from plant.errors import InputError
from plant.model.linear import MAX_STATES
from plant.texts import PlainTable
from tuner.extensions.plant_fit.intervals import FittedPlant

Array = np.ndarray
Realized = tuple[PlainTable, dict[str, float], Array, list[float]]


def realized(plants: Sequence[FittedPlant], period: float) -> Realized:
    """Return the numbers of [plant], parameters, covariance and delays [s].

    Args:
        plants: Plant of each output.
        period: Control period [s], of which delays are multiples.
    """
    if len(plants) == 1 and len(plants[0].solution.shape) == 1:
        return _transfer_function(plants[0], period)
    return _state_space(plants, period)


def _multiple(dead_time: float, period: float) -> float:
    return float(f"{round(dead_time / period) * period:.12g}")


def _transfer_function(plant: FittedPlant, period: float) -> Realized:
    order, zeros = plant.solution.structure.order, plant.solution.structure.zeros
    names = [f"b{k}" for k in range(zeros, -1, -1)] + [f"a{k}" for k in range(order, -1, -1)]
    values, covariance = plant.deviations(lambda parameters: np.concatenate(plant.coefficients(0, parameters)))
    values = np.array([float(f"{value:.8g}") for value in values])
    table: PlainTable = {
        "transfer_function": {
            "numerator": values[: zeros + 1].tolist(),
            "denominator": values[zeros + 1 :].tolist(),
        }
    }
    delay = _multiple(float(plant.solution.dead_times[0]), period)
    return table, dict(zip(names, values.tolist(), strict=True)), covariance, [delay]


def _state_space(plants: Sequence[FittedPlant], period: float) -> Realized:
    """Return a block of states for each pair.

    A dead time beyond the input's becomes a second-order Padé term.
    """
    m = len(plants[0].solution.shape)
    delays = [min(float(each.solution.dead_times[j]) for each in plants) for j in range(m)]
    pads = [[float(each.solution.dead_times[j]) - delays[j] for j in range(m)] for each in plants]
    n_states = sum(
        m * each.solution.structure.order + 2 * sum(late > 0.5 * period for late in row)
        for each, row in zip(plants, pads, strict=True)
    )
    if n_states > MAX_STATES:
        raise InputError(
            f"this plant of {m} inputs and {len(plants)} outputs has {n_states} states; a study takes up to {MAX_STATES}: "
            "name a simpler structure, or fewer columns",
            key="structure",
        )

    def matrices(parts: Sequence[Array]) -> tuple[Array, Array, Array]:
        a, b, c = np.zeros((n_states, n_states)), np.zeros((n_states, m)), np.zeros((len(plants), n_states))
        place = 0
        for i, (plant, parameters) in enumerate(zip(plants, parts, strict=True)):
            for j in range(m):
                numerator, denominator = plant.coefficients(j, parameters)
                if pads[i][j] > 0.5 * period:
                    above, below = _pade(pads[i][j])
                    numerator, denominator = np.convolve(numerator, above), np.convolve(denominator, below)
                n = len(denominator) - 1
                block = slice(place, place + n)
                monic = denominator / denominator[0]
                pace = float(np.abs(monic[np.flatnonzero(monic)[-1]]) ** (1.0 / max(np.flatnonzero(monic)[-1], 1)))
                powers = pace ** np.arange(n)
                a[block, block] = np.eye(n, k=1) * pace
                a[place + n - 1, block] = -monic[:0:-1] * powers / pace ** (n - 1)
                b[place + n - 1, j] = 1.0
                rising = numerator[::-1] / denominator[0]
                c[i, place : place + len(rising)] = rising * powers[: len(rising)] / pace ** (n - 1)
                place += n
        return a, b, c

    middles = [plant.parameters for plant in plants]
    a, b, c = matrices(middles)
    entries = [("a", i, j, a[i, j]) for i, j in np.argwhere(a)] + [("c", i, j, c[i, j]) for i, j in np.argwhere(c)]
    covariance = np.zeros((len(entries), len(entries)))
    for i, plant in enumerate(plants):

        def values(parameters: Array, i: int = i) -> Array:
            parts = [*middles[:i], parameters, *middles[i + 1 :]]
            first, _, last = matrices(parts)
            return np.array([{"a": first, "c": last}[kind][row, column] for kind, row, column, _ in entries])

        # Outputs are fitted one by one, so their errors count as independent.
        covariance += plant.deviations(values)[1]
    table: PlainTable = {"state_space": {"A": a.tolist(), "B": b.tolist(), "C": c.tolist()}}
    names = {f"{kind}_{i + 1}_{j + 1}": float(value) for kind, i, j, value in entries}
    return table, names, covariance, [_multiple(delay, period) for delay in delays]


def _pade(dead_time: float) -> tuple[Array, Array]:
    """Return the second-order Padé term of a dead time [s]."""
    square, first = dead_time**2 / 12.0, dead_time / 2.0
    return np.array([square, -first, 1.0]), np.array([square, first, 1.0])
