"""Normalization of objectives, for searches that measure distances between them.

NSGA-III and AGE-MOEA as implemented by pymoo take differences below 1e-3, 1e-6 or 1e-12 for none, whatever the unit, and one
distance of AGE-MOEA's is taken from the origin. Shifted and scaled first, they answer the same in metres and millimetres.
"""

import numpy as np

from tuner.search.constraint_ranking import power_of_two


class Scaling:
    """Affine map of objectives, fixed by the first generation with feasible candidates."""

    def __init__(self) -> None:
        self._low: np.ndarray | None = None
        self._spread: np.ndarray | None = None

    def of(self, values: np.ndarray, feasible: np.ndarray) -> np.ndarray:
        """Return values (n, m) above the smallest: in units of the spread; infeasible rows (n,) are 0.

        Values of infeasible candidates have no bearing, and those of failed flights would drown the others.
        """
        if self._low is None and feasible.any():
            ordered = np.sort(values[feasible], axis=0)
            self._low, self._spread = ordered[0], np.array([spread(column) for column in ordered.T])
        scaled = np.zeros_like(values)
        if self._low is not None and self._spread is not None:
            scaled[feasible] = (values[feasible] - self._low) / self._spread
        return scaled


def spread(ordered: np.ndarray) -> float:
    """Return the range of ordered values (n,): of the first quarter, else the half, else all; 1 if they are equal.

    The quarter, because half of a first generation may have failed, at a cost above all others. A power of two, so that
    dividing by it does not round.
    """
    for share in (4, 2, 1):
        reach = float(ordered[(len(ordered) - 1) // share] - ordered[0])
        if reach > 0.0:
            return power_of_two(reach)
    return 1.0
