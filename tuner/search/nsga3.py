"""NSGA-III. For four objectives and more, where most of a population is non-dominated and crowding says little.

K. Deb, H. Jain, "An evolutionary many-objective optimization algorithm using reference-point-based nondominated sorting
approach, part I", IEEE Trans. Evolutionary Computation 18(4):577-601, 2014; constraints as in part II, 18(4):602-622; as
implemented by pymoo.
"""

import numpy as np
from pymoo.algorithms.moo.nsga3 import NSGA3
from pymoo.operators.selection.tournament import TournamentSelection
from pymoo.util.ref_dirs import get_reference_directions

from tuner.search.pymoo_search import PymooSearch


class Nsga3(PymooSearch):
    """NSGA-III: ranks by dominance, then by niches of reference directions.

    A population may be larger than the number of directions: a direction then keeps more than one point.
    """

    def __init__(self, first: np.ndarray, n_objectives: int, n_constraints: int, seed: int) -> None:
        algorithm = NSGA3(
            reference_directions(n_objectives, len(first)),
            pop_size=len(first),
            selection=TournamentSelection(func_comp=less_violating),
        )
        super().__init__(algorithm, first, n_objectives, n_constraints, seed, scaled=True)


def reference_directions(n_objectives: int, most: int) -> np.ndarray:
    """Return Das-Dennis directions (k, m) of the positive orthant, at most so many.

    I. Das, J. E. Dennis, SIAM J. Optimization 8(3):631-657, 1998: with p divisions of each axis there are C(m + p - 1, p).
    most: at least m.
    """
    assert most >= n_objectives, "a population has a candidate for each objective"
    directions = get_reference_directions("das-dennis", n_objectives, n_partitions=1)
    for divisions in range(2, most):
        finer = get_reference_directions("das-dennis", n_objectives, n_partitions=divisions)
        if len(finer) > most:
            break
        directions = finer
    return directions


def less_violating(pop: object, pairs: np.ndarray, random_state: np.random.Generator, **_: object) -> np.ndarray:
    """Return the winners (n, 1) of pairs (n, 2) of rows of a population: the smaller total violation, else either.

    In place of pymoo's own, which decides ties between infeasible candidates by a generator that it seeds from the system.
    """
    violation = pop.get("CV")[:, 0][pairs]  # pyright: ignore[reportAttributeAccessIssue]
    either = random_state.integers(2, size=len(pairs))
    winner = np.where(violation[:, 0] == violation[:, 1], either, np.argmin(violation, axis=1))
    return pairs[np.arange(len(pairs)), winner][:, None]
