"""constraints.csv of a run: the constrained quantities of every finalist on held-out scenarios, with intervals.

front.csv holds the objectives; this holds what must stay below a limit, from the same flights and the same resamples.
"""

from typing import TYPE_CHECKING, Any

import numpy as np

from objectives.risk import interval_on, paired_difference_on, resampled_scenarios, within
from plant.seeds import generator
from tuner.analysis.held_out import FRONT_REPLICATES

if TYPE_CHECKING:
    from tuner.experiments.tuning.outcome import Outcome

COLUMNS = ("point", "label", "value", "low", "high", "difference", "difference_low", "difference_high")


def constraint_table(outcome: "Outcome") -> Any:
    """Return a pandas table, a row for each finalist and constraint, in SI units; difference: to the default, paired."""
    import pandas as pd

    study, evaluation = outcome.study, outcome.finalists.evaluation
    drawn = resampled_scenarios(generator(study.seed, "bootstrap/front", 0), FRONT_REPLICATES, evaluation.origin)
    rows = []
    for i, constraint in enumerate(study.constraints, start=len(study.objectives)):
        quantity = constraint.objective
        samples = evaluation.samples(i, quantity.scenario)
        part = within(drawn, evaluation.origin, quantity.scenario)
        low, high = interval_on(samples, quantity.risk, part)
        default = np.broadcast_to(samples[0], samples.shape)
        numbers = (
            quantity.risk.apply(samples), low, high, *paired_difference_on(samples, default, quantity.risk, part),
        )  # fmt: skip
        rows += [(name, quantity.label, *values) for name, *values in zip(outcome.names, *numbers, strict=True)]
    return pd.DataFrame(rows, columns=pd.Index(COLUMNS))
