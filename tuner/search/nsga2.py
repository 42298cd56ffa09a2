"""NSGA-II on the unit cube, whole generations at a time. For two or three objectives; the default search.

K. Deb, A. Pratap, S. Agarwal, T. Meyarivan, "A fast and elitist multiobjective genetic algorithm: NSGA-II", IEEE Trans.
Evolutionary Computation 6(2):182-197, 2002, as implemented by pymoo (J. Blank, K. Deb, IEEE Access 8, 2020); infeasible
candidates rank behind feasible ones by their total violation.
"""

import numpy as np
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.evaluator import Evaluator
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.core.termination import NoTermination
from pymoo.problems.static import StaticProblem


class Nsga2:
    """Ask for a generation of points, tell what they were worth.

    first: points (n, d) of the first generation; its size is the population. seed: of all later draws.
    """

    def __init__(self, first: np.ndarray, n_objectives: int, n_constraints: int, seed: int) -> None:
        self._problem = Problem(n_var=first.shape[1], n_obj=n_objectives, n_ieq_constr=n_constraints, xl=0.0, xu=1.0)
        self._algorithm = NSGA2(pop_size=len(first), sampling=first.copy())  # pyright: ignore[reportArgumentType]
        self._algorithm.setup(self._problem, termination=NoTermination(), seed=seed, verbose=False)
        self._asked: Population | None = None

    def ask(self) -> np.ndarray:
        """Return the next generation (n, d), points of the unit cube."""
        asked = self._algorithm.ask()
        assert asked is not None, "the search has no end of its own"
        self._asked = asked
        return np.array(asked.get("X"), dtype=float)

    def tell(self, values: np.ndarray, violations: np.ndarray) -> None:
        """Tell the objectives (n, m) and constraint violations (n, c) of the generation asked for."""
        assert self._asked is not None, "ask before tell"
        outcome = {"F": values.copy()} | ({"G": violations.copy()} if violations.shape[1] else {})
        Evaluator().eval(StaticProblem(self._problem, **outcome), self._asked)
        self._algorithm.tell(infills=self._asked)
        self._asked = None
