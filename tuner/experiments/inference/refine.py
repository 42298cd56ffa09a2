"""Levenberg-Marquardt refinement of the best setting of a search.

With common random numbers the misfit, a sum of squares, is nearly smooth. A round flies both neighbors of the best setting along
every unknown, and from these the steps (J' J + d I) step = -J' r for several dampings d. It continues from the best of all, with
closer neighbors where none is better. K. Levenberg, Quarterly of Applied Mathematics 2:164-168, 1944; D. W. Marquardt, J. SIAM
11(2):431-441, 1963.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from plant.ties import first_smallest
from tuner.experiments.inference.misfit import EvaluatedSettings, best_row, concatenate, log_ratio, overall, weights
from tuner.study.inference import Inference

# Distance of the neighbours, in shares of the range of an unknown: at first, and the least that is tried.
FAR, CLOSE = 0.04, 0.01
# Dampings, in shares of the mean diagonal of J' J.
DAMPINGS = (0.001, 0.01, 0.1, 1.0, 10.0)
ROUNDS = 8
# Smallest relative decrease of the misfit that counts as one; rounding decides below.
MIN_DECREASE = 1e-9

Fly = Callable[[np.ndarray], EvaluatedSettings]
"""Flies points (n, unknowns) of the unit cube."""


@dataclass(frozen=True)
class Jacobian:
    """Jacobian (cells, unknowns) of the log ratios: by the unknowns in shares of their ranges.

    point (unknowns,): of the unit cube; the derivative is 0 where the cells do not depend on an unknown.
    """

    point: np.ndarray
    matrix: np.ndarray


def refine(
    inference: Inference, start: np.ndarray, before: EvaluatedSettings, fly: Fly
) -> tuple[EvaluatedSettings, Jacobian]:
    """Return all settings flown, `before` included, and the last Jacobian.

    start (unknowns,): point of the unit cube of the best setting of `before`.
    """
    settings, point, reach = before, start, FAR
    jacobian = Jacobian(start, np.zeros((len(inference.cells), len(start))))
    for _ in range(ROUNDS):
        least = settings.overall(inference).min(axis=0)
        around = neighbors(point, reach)
        flown = fly(around)
        jacobian = jacobian_at(inference, point, around, flown)
        ratios_at_best = log_ratio(settings.median[best_row(settings.misfits(inference))], inference.published)
        trials = steps(inference, jacobian, ratios_at_best)
        parts, points = concatenate([flown, fly(trials)]), np.concatenate([around, trials], axis=0)
        settings = concatenate([settings, parts])
        misfit = overall(parts.misfits(inference))
        if misfit.min(axis=0) < (1.0 - MIN_DECREASE) * least:
            point = points[first_smallest(misfit)]
        elif reach <= CLOSE:
            break
        else:
            reach = max(0.5 * reach, CLOSE)
    return settings, jacobian


def neighbors(point: np.ndarray, reach: float) -> np.ndarray:
    """Return the neighbors (2 unknowns, unknowns) along every unknown, in the unit cube."""
    moves = reach * np.eye(len(point))
    return np.clip(np.concatenate([point - moves, point + moves], axis=0), 0.0, 1.0)


def jacobian_at(inference: Inference, point: np.ndarray, around: np.ndarray, flown: EvaluatedSettings) -> Jacobian:
    """Return the Jacobian from central differences of neighbors."""
    ratios = log_ratio(flown.median, inference.published)
    count = len(point)
    distances = np.diag(around[count:] - around[:count])
    return Jacobian(point, ((ratios[count:] - ratios[:count]) / distances[:, None]).T)


def steps(inference: Inference, jacobian: Jacobian, ratios: np.ndarray) -> np.ndarray:
    """Return the Levenberg-Marquardt points (dampings, unknowns); ratios (cells,): logarithms at the point."""
    scale = np.sqrt(weights(inference.kind_of))
    matrix, rest = scale[:, None] * jacobian.matrix, scale * ratios
    square = matrix.T @ matrix
    unit = np.trace(square) / len(square) + np.finfo(float).tiny
    moved = [
        jacobian.point - np.linalg.solve(square + damping * unit * np.eye(len(square)), matrix.T @ rest)
        for damping in DAMPINGS
    ]
    return np.clip(moved, 0.0, 1.0)
