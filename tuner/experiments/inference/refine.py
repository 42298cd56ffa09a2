"""From the best setting of a search down to the least misfit nearby, by damped least squares.

The misfit is a sum of squares, and with common random numbers a nearly smooth function of the setting, so its derivatives
say where it falls. A round flies both neighbours of the best setting along every unknown, and from these the steps

    (J' J + d I) step = -J' r,    d: several dampings, from a Gauss-Newton step to a short one downhill.

It goes on from the best of all of them, and draws the neighbours closer where none is better. Source: K. Levenberg,
Quarterly of Applied Mathematics 2:164-168, 1944; D. W. Marquardt, J. SIAM 11(2):431-441, 1963.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tuner.experiments.inference.misfit import EvaluatedSettings, best_row, concatenate, log_ratio, overall, weights
from tuner.study.inference import Inference

# Distance of the neighbours, in shares of the range of an unknown: at first, and the least that is tried.
FAR, CLOSE = 0.04, 0.01
# Dampings, in shares of the mean diagonal of J' J.
DAMPINGS = (0.001, 0.01, 0.1, 1.0, 10.0)
ROUNDS = 8

Fly = Callable[[np.ndarray], EvaluatedSettings]
"""Flies points (n, unknowns) of the unit cube."""


@dataclass(frozen=True)
class Slope:
    """Derivatives (cells, unknowns) of the log ratios of the cells by the unknowns, each in shares of its range.

    point (unknowns,): where, in the unit cube; the derivative is 0 where the cells do not depend on an unknown.
    """

    point: np.ndarray
    matrix: np.ndarray


def refined(
    inference: Inference, start: np.ndarray, before: EvaluatedSettings, fly: Fly
) -> tuple[EvaluatedSettings, Slope]:
    """Return all settings flown, `before` included, and the slope at the last best one but for the final step.

    start (unknowns,): point of the unit cube of the best setting of `before`.
    """
    found, point, reach = before, start, FAR
    slope = Slope(start, np.zeros((len(inference.cells), len(start))))
    for _ in range(ROUNDS):
        least = found.overall(inference).min(axis=0)
        around = neighbours(point, reach)
        flown = fly(around)
        slope = slope_of(inference, point, around, flown)
        here = log_ratio(found.median[best_row(found.misfits(inference))], inference.published)
        trials = steps(inference, slope, here)
        parts, points = concatenate([flown, fly(trials)]), np.concatenate([around, trials], axis=0)
        found = concatenate([found, parts])
        misfit = overall(parts.misfits(inference))
        if misfit.min(axis=0) < least:
            point = points[np.argmin(misfit)]
        elif reach <= CLOSE:
            break
        else:
            reach = max(0.5 * reach, CLOSE)
    return found, slope


def neighbours(point: np.ndarray, reach: float) -> np.ndarray:
    """Return the points (2 unknowns, unknowns) below and above along every unknown, inside the unit cube."""
    moves = reach * np.eye(len(point))
    return np.clip(np.concatenate([point - moves, point + moves], axis=0), 0.0, 1.0)


def slope_of(inference: Inference, point: np.ndarray, around: np.ndarray, flown: EvaluatedSettings) -> Slope:
    """Return the derivatives between the lower and the upper neighbours of a point."""
    ratios = log_ratio(flown.median, inference.published)
    count = len(point)
    apart = np.diag(around[count:] - around[:count])
    return Slope(point, ((ratios[count:] - ratios[:count]) / apart[:, None]).T)


def steps(inference: Inference, slope: Slope, ratios: np.ndarray) -> np.ndarray:
    """Return the points (dampings, unknowns) that damped least squares goes to; ratios (cells,): logarithms at the point."""
    scale = np.sqrt(weights(inference.kind_of))
    matrix, rest = scale[:, None] * slope.matrix, scale * ratios
    square = matrix.T @ matrix
    unit = np.trace(square) / len(square) + np.finfo(float).tiny
    moved = [
        slope.point - np.linalg.solve(square + damping * unit * np.eye(len(square)), matrix.T @ rest)
        for damping in DAMPINGS
    ]
    return np.clip(moved, 0.0, 1.0)
