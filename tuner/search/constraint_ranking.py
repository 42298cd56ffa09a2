"""Rank of candidates where constraints are broken: feasible ones first, then the smaller total violation.

K. Deb, "An efficient constraint handling method for genetic algorithms", Computer Methods in Applied Mechanics and
Engineering 186(2-4):311-338, 2000, section 3.
"""

import numpy as np


class TotalViolation:
    """Adds up violations of constraints that have different units: metres, seconds, shares, or relative to a limit.

    Each constraint counts in units of its median violation in the first generation in which any candidate breaks it.
    The unit stays as it is, so that totals of different generations compare. It is a power of two: where one constraint
    is broken, dividing by it cannot reorder candidates by rounding.
    """

    def __init__(self, n_constraints: int) -> None:
        self._units = np.full(n_constraints, np.nan)

    def of(self, violations: np.ndarray) -> np.ndarray:
        """Return the dimensionless totals (n,) of violations (n, c); 0 where every constraint is satisfied."""
        broken = np.maximum(violations, 0.0)
        for i in np.flatnonzero(np.isnan(self._units) & np.any(broken > 0.0, axis=0)):
            self._units[i] = power_of_two(float(np.median(broken[broken[:, i] > 0.0, i], axis=0)))
        return np.sum(broken / np.where(np.isnan(self._units), 1.0, self._units), axis=1)


def power_of_two(value: float) -> float:
    """Return the largest power of two up to a value above 0."""
    return float(np.ldexp(1.0, int(np.frexp(value)[1]) - 1))


def feasibility_order(values: np.ndarray, totals: np.ndarray) -> np.ndarray:
    """Return the rows of one objective (n,) in Deb's order: smallest total violation (n,), then smallest value, then first."""
    return np.lexsort((values, totals))
