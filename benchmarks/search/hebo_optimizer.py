"""HEBO with one objective and no constraint, else the general optimizer of its package.

A. I. Cowen-Rivers et al., "HEBO: Pushing the limits of sample-efficient hyperparameter optimisation", JAIR 74:1269-1349, 2022;
version 0.3.6.
"""

import warnings

import numpy as np
import pandas as pd
import torch
from hebo.design_space.design_space import DesignSpace
from hebo.optimizers.general import GeneralBO
from hebo.optimizers.hebo import HEBO

from benchmarks.search.peer import Array, Start


def begun(start: Start) -> "Optimizer":
    """Return the search at its beginning."""
    return Optimizer(start)


class Optimizer:
    """An optimizer of HEBO that is asked and told."""

    def __init__(self, start: Start) -> None:
        warnings.simplefilter("ignore")
        np.random.seed(start.seed)
        torch.manual_seed(start.seed)
        torch.set_num_threads(1)
        self._names = [f"x{i:02d}" for i in range(start.first.shape[1])]
        space = DesignSpace().parse([{"name": name, "type": "num", "lb": 0.0, "ub": 1.0} for name in self._names])
        first = len(start.first)
        if start.objectives == 1 and not start.limits:
            self._optimizer = HEBO(space, rand_sample=first, scramble_seed=start.seed)
        else:
            self._optimizer = GeneralBO(space, start.objectives, start.limits, rand_sample=first)
        self._batch = start.batch
        self._asked = pd.DataFrame(start.first, columns=self._names)
        self._is_begun = False

    def ask(self) -> Array:
        """Return the next batch (n, d)."""
        if self._is_begun:
            self._asked = self._optimizer.suggest(n_suggestions=self._batch)
        self._is_begun = True
        return self._asked[self._names].to_numpy(dtype=float)

    def tell(self, values: Array, violations: Array) -> None:
        """Tell objectives (n, m) and constraint values (n, c) of the batch."""
        outputs = np.concatenate([values, violations], axis=1)
        if isinstance(self._optimizer, HEBO):
            self._optimizer.observe(self._asked, outputs)
        else:
            self._optimizer.observe_new_data(self._asked, outputs)
