"""NSGA-II. For two or three objectives; the default search.

K. Deb, A. Pratap, S. Agarwal, T. Meyarivan, "A fast and elitist multiobjective genetic algorithm: NSGA-II", IEEE Trans.
Evolutionary Computation 6(2):182-197, 2002, as implemented by pymoo; infeasible candidates rank behind feasible ones by
their total violation.
"""

import numpy as np
from pymoo.algorithms.moo.nsga2 import NSGA2

from tuner.search.pymoo_search import PymooSearch


class Nsga2(PymooSearch):
    """NSGA-II: ranks by dominance, then by crowding distance."""

    def __init__(self, first: np.ndarray, n_objectives: int, n_constraints: int, seed: int) -> None:
        super().__init__(NSGA2(pop_size=len(first)), first, n_objectives, n_constraints, seed)
