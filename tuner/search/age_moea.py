"""AGE-MOEA. For three objectives and more on fronts whose shape is not known: no reference directions to choose.

A. Panichella, "An adaptive evolutionary algorithm based on non-Euclidean geometry for many-objective optimization", GECCO
2019, pages 595-603, as implemented by pymoo.
"""

from pathlib import Path

import numpy as np
from pymoo.algorithms.moo import age
from pymoo.algorithms.moo.age import AGEMOEA, AGEMOEASurvival, find_corner_solutions, point_2_line_distance

from plant.backends.cache import keep_file
from tuner.search.pymoo_search import PymooSearch

# pymoo has numba compile these in every process, for 5 s; once for a machine is enough. One calls another, which is inlined,
# see `plant.backends.cache`.
point_2_line_distance.targetoptions["forceinline"] = True
for compiled in (point_2_line_distance, find_corner_solutions, AGEMOEASurvival.minkowski_distances):
    keep_file(compiled, Path(str(age.__file__)))


class AgeMoea(PymooSearch):
    """AGE-MOEA: ranks by dominance, then by spread and depth in the p-norm that fits the front."""

    def __init__(self, first: np.ndarray, n_objectives: int, n_constraints: int, seed: int) -> None:
        super().__init__(AGEMOEA(pop_size=len(first)), first, n_objectives, n_constraints, seed, scaled=True)
