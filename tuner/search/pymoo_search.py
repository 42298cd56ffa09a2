"""A genetic algorithm of pymoo on the unit cube; it evaluates full generations and honors its seed.

J. Blank, K. Deb, "pymoo: Multi-objective optimization in Python", IEEE Access 8:89497-89509, 2020; version 0.6.
"""

import warnings

import numpy as np
from pymoo.algorithms.base.genetic import GeneticAlgorithm
from pymoo.core.evaluator import Evaluator
from pymoo.core.initialization import Initialization
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.core.termination import NoTermination
from pymoo.problems.static import StaticProblem

from tuner.search.constraint_ranking import TotalViolation
from tuner.search.scaling import Scaling


class PymooSearch:
    """A genetic algorithm of pymoo behind the interface of a search.

    Args:
        algorithm: Algorithm of the population of `first`.
        first: Points (n, d) of the first generation.
        n_objectives: Number of objectives.
        n_constraints: Number of constraints.
        seed: Seed of all draws.
        scaled: Whether the algorithm measures distances between objectives, see `scaling`.
    """

    def __init__(
        self,
        algorithm: GeneticAlgorithm,
        first: np.ndarray,
        n_objectives: int,
        n_constraints: int,
        seed: int,
        scaled: bool = False,
    ) -> None:
        self._scaling = Scaling() if scaled else None
        # pymoo sees the total violation as its one constraint: its own total adds metres to seconds.
        limits = min(n_constraints, 1)
        self._problem = Problem(n_var=first.shape[1], n_obj=n_objectives, n_ieq_constr=limits, xl=0.0, xu=1.0)
        self._total = TotalViolation(n_constraints)
        self._algorithm = algorithm
        # As it was given: by default two equal starting points would become one, and the generation one short.
        self._algorithm.initialization = Initialization(first.copy())
        self._algorithm.setup(self._problem, termination=NoTermination(), seed=seed, verbose=False)
        self._population = len(first)
        self._pending: Population | None = None
        self._points = np.empty((0, first.shape[1]))

    def ask(self) -> np.ndarray:
        """Return the next generation (n, d), points of the unit cube."""
        pending = self._algorithm.ask()
        # Mating leaves out copies and tries a hundred times; a mutation on a bound is a copy three times in four at worst.
        assert pending is not None and len(pending) == self._population, "mating found no further points"
        self._pending = pending
        return np.asarray(pending.get("X"), dtype=float)

    def tell(self, values: np.ndarray, violations: np.ndarray) -> None:
        """Record the objectives (n, m) and constraint violations (n, c) of the pending generation."""
        assert self._pending is not None, "ask before tell"
        self._points = np.concatenate([self._points, self._pending.get("X")])
        self._evaluate(self._pending, values, violations)
        # NSGA-III turns warnings off, and for the whole process.
        with warnings.catch_warnings():
            self._algorithm.tell(infills=self._pending)
        self._pending = None

    def retell(self, values: np.ndarray, violations: np.ndarray) -> None:
        """Replace the objectives (n, m) and constraint violations (n, c) of all points so far: the best of them survive."""
        every = Population.new(X=self._points)
        self._evaluate(every, values, violations)
        one = self._algorithm
        assert one.survival is not None, "a genetic algorithm selects survivors"
        with warnings.catch_warnings():
            one.pop = one.survival.do(
                self._problem, every, n_survive=self._population, algorithm=one, random_state=one.random_state
            )

    def _evaluate(self, population: Population, values: np.ndarray, violations: np.ndarray) -> None:
        total = self._total.of(violations)
        outcome = {"F": values if self._scaling is None else self._scaling.of(values, total <= 0.0)}
        if self._problem.n_ieq_constr:
            outcome["G"] = total[:, None]
        Evaluator().eval(StaticProblem(self._problem, **outcome), population)
