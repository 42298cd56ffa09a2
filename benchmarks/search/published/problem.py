"""A published problem, its variables scaled to the unit cube."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Array = np.ndarray
# What stands for a quotient by 0, at bounds of some problems.
LARGEST = 1e12


@dataclass(frozen=True)
class PublishedProblem:
    """A problem to minimize.

    Attributes:
        evaluate_physical: Variables (n, d) -> objectives (n, m) and constraint values (n, c), 0 or less where satisfied.
        lower: Lower bounds (d,) of the variables.
        upper: Upper bounds (d,).
        n_objectives: Number of objectives m.
        n_constraints: Number of constraints c.
        front: Returns the exact Pareto front (k, m); None where no formula has it.
        optimum: Least feasible value in the literature, of a single objective.
        noise: Standard deviation of the noise of the objectives, in shares of their values.
        reference: Name of the problem with the same front.
    """

    evaluate_physical: Callable[[Array], tuple[Array, Array]]
    lower: Array
    upper: Array
    n_objectives: int
    n_constraints: int
    front: Callable[[], Array] | None = None
    optimum: float | None = None
    noise: float = 0.0
    reference: str = ""

    @property
    def dimension(self) -> int:
        """Return the number of variables."""
        return len(self.lower)

    def evaluate(self, points: Array) -> tuple[Array, Array]:
        """Return objectives (n, m) and constraint values (n, c) of points (n, d) of the unit cube, without noise."""
        with np.errstate(divide="ignore", invalid="ignore"):
            columns = self.evaluate_physical(self.lower + points * (self.upper - self.lower))
        objectives, constraints = (np.nan_to_num(part, nan=LARGEST, posinf=LARGEST) for part in columns)
        return objectives, constraints

    def disturb(self, objectives: Array, rng: np.random.Generator) -> Array:
        """Return objectives (n, m) with noise."""
        if not self.noise:
            return objectives
        return objectives * (1.0 + self.noise * rng.standard_normal(objectives.shape))
