"""Scrambled Sobol sequence: a look at the whole space. For few gains, and to see what a front leaves out.

I. M. Sobol', USSR Computational Mathematics and Mathematical Physics 7(4):86-112, 1967; direction numbers of S. Joe, F. Y. Kuo,
SIAM J. Scientific Computing 30(5):2635-2654, 2008, scrambled by J. Matousek, J. Complexity 14(4):527-556, 1998, as
implemented by SciPy.
"""

import numpy as np
from scipy.stats.qmc import Sobol

from plant.seeds import generator


class SobolSequence:
    """Ask for a generation of points; what it is told changes nothing.

    first: points (n, d) of the first generation; its size is the population. The sequence begins with the second
    generation. seed: of the scrambling.
    """

    def __init__(self, first: np.ndarray, n_objectives: int, n_constraints: int, seed: int) -> None:
        self._sequence = Sobol(first.shape[1], scramble=True, rng=generator(seed, "search/sobol", 0))
        # SciPy warns of a first draw that is no power of two long; the sequence is the same however it is drawn.
        self._next = self._sequence.random(1)
        self._points = first.copy()

    def ask(self) -> np.ndarray:
        """Return the next generation (n, d), points of the unit cube."""
        return self._points.copy()

    def tell(self, values: np.ndarray, violations: np.ndarray) -> None:
        """Tell the objectives (n, m) and constraint violations (n, c) of the generation asked for."""
        drawn = np.concatenate([self._next, self._sequence.random(len(self._points))], axis=0)
        self._points, self._next = drawn[:-1], drawn[-1:]
