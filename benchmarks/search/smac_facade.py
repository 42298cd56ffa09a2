"""SMAC's facade for black boxes: a Gaussian process, ParEGO for several objectives; it takes no constraints.

M. Lindauer et al., "SMAC3: A versatile Bayesian optimization package for hyperparameter optimization", JMLR 23(54):1-9, 2022;
J. Knowles, "ParEGO", IEEE Transactions on Evolutionary Computation 10(1):50-66, 2006; version 2.4.
"""

import warnings
from tempfile import mkdtemp

import numpy as np
from ConfigSpace import Configuration, ConfigurationSpace, Float
from smac import BlackBoxFacade, Scenario
from smac.multi_objective.parego import ParEGO
from smac.runhistory import TrialInfo, TrialValue

from benchmarks.search.peer import Array, Start

MAX_EVALUATIONS = 100_000


def begun(start: Start) -> "Facade":
    """Return the search at its beginning."""
    return Facade(start)


class Facade:
    """A facade that is asked and told, one point after the other."""

    def __init__(self, start: Start) -> None:
        warnings.simplefilter("ignore")
        self._names = [f"x{i:02d}" for i in range(start.first.shape[1])]
        space = ConfigurationSpace(space=[Float(name, (0.0, 1.0)) for name in self._names], seed=start.seed)
        first = [Configuration(space, dict(zip(self._names, point, strict=True))) for point in start.first.tolist()]
        scenario = Scenario(
            space,
            objectives=[f"f{i}" for i in range(start.objectives)],
            deterministic=True,
            n_trials=MAX_EVALUATIONS,
            seed=start.seed,
            output_directory=mkdtemp(),
        )
        self._facade = BlackBoxFacade(
            scenario,
            lambda config, seed=0: 0.0,
            initial_design=BlackBoxFacade.get_initial_design(scenario, n_configs=0, additional_configs=first),
            multi_objective_algorithm=ParEGO(scenario) if start.objectives > 1 else None,
            logging_level=40,
            overwrite=True,
        )
        self._asked: TrialInfo | None = None

    def ask(self) -> Array:
        """Return the next point (1, d)."""
        self._asked = self._facade.ask()
        return np.array([[self._asked.config[name] for name in self._names]])

    def tell(self, values: Array, violations: Array) -> None:
        """Tell the objectives (1, m) of the point."""
        assert self._asked is not None
        cost = values[0].tolist()
        self._facade.tell(self._asked, TrialValue(cost=cost if len(cost) > 1 else cost[0]))
