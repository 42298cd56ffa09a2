"""pymoo's own genetic algorithms as they come, constraints handled as pymoo does.

J. Blank, K. Deb, "pymoo: Multi-objective optimization in Python", IEEE Access 8:89497-89509, 2020; version 0.6.
"""

import numpy as np
from pymoo.algorithms.moo.age2 import AGEMOEA2
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.evaluator import Evaluator
from pymoo.core.problem import Problem
from pymoo.core.termination import NoTermination
from pymoo.problems.static import StaticProblem

from benchmarks.search.peer import Array, Start

ALGORITHMS = {"NSGA2": NSGA2, "AGEMOEA2": AGEMOEA2}


def begun(start: Start, algorithm: str) -> "Genetic":
    """Return an algorithm by its class name at its beginning."""
    # AGE-MOEA2 has numba compile for 6 s in the first generations of a process; that is no time of the search.
    warm = Genetic(start, algorithm)
    for _ in range(8):
        points = warm.ask()
        warm.tell(np.linspace(points, 1.0 - points, start.objectives)[:, :, 0].T, np.zeros((len(points), start.limits)))
    return Genetic(start, algorithm)


class Genetic:
    """A genetic algorithm of pymoo that is asked and told; its population is the first batch."""

    def __init__(self, start: Start, name: str) -> None:
        self._problem = Problem(
            n_var=start.first.shape[1], n_obj=start.objectives, n_ieq_constr=start.limits, xl=0.0, xu=1.0
        )
        self._algorithm = ALGORITHMS[name](pop_size=len(start.first), sampling=start.first)
        self._algorithm.setup(self._problem, termination=NoTermination(), seed=start.seed, verbose=False)

    def ask(self) -> Array:
        """Return the next batch (n, d), an empty one where mating finds nothing new."""
        self._asked = self._algorithm.ask()
        return np.empty((0, self._problem.n_var)) if self._asked is None else self._asked.get("X").astype(float)

    def tell(self, values: Array, violations: Array) -> None:
        """Tell objectives (n, m) and violations (n, c) of the batch asked for."""
        Evaluator().eval(StaticProblem(self._problem, F=values, G=violations), self._asked)
        self._algorithm.tell(infills=self._asked)
