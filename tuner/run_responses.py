"""The responses that a run keeps for its report: default, tuned and the best point of each objective."""

from typing import TYPE_CHECKING, Any

import numpy as np

from plant.scenarios import HELD_OUT, sample_scenarios
from tuner.responses import fan_table, fly_responses
from tuner.store.tables import point_name

if TYPE_CHECKING:
    from tuner.conclusion import Outcome

# Held-out scenarios a fan is drawn from: its 5 % and 95 % lines rest on three flights each.
FAN_SCENARIOS = 64


def shown_points(outcome: "Outcome") -> dict[str, int]:
    """Return the finalists whose responses are kept, name -> row."""
    values = outcome.finalists.evaluation.values
    rows = {"default": 0, point_name(int(outcome.candidates[outcome.tuned - 1])): outcome.tuned}
    among = np.flatnonzero(outcome.finalists.non_dominated)
    for i in range(values.shape[1] if len(among) else 0):
        best = int(among[np.argmin(values[among, i])])
        rows[point_name(int(outcome.candidates[best - 1]))] = best
    return rows


def response_table(outcome: "Outcome") -> Any:
    """Fly the shown points through held-out scenarios and return their fans as one long pandas table."""
    import pandas as pd

    study, system = outcome.study, outcome.study.system
    parts = []
    for entry in study.scenarios:
        count = min(FAN_SCENARIOS, entry.held_out)
        inputs = sample_scenarios(entry.spec, system.vehicle, system.timing, study.seed, HELD_OUT, range(count))
        for name, row in shown_points(outcome).items():
            flown = fly_responses(
                outcome.problem.flyer, outcome.gains(row), system.nominal, inputs, system.timing.control_period
            )
            parts.append(fan_table(flown, name, entry.spec.name))
    return pd.concat(parts, ignore_index=True)
