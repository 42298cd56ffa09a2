"""The responses that a run keeps for its report: of the default and of every finalist, in every scenario.

For each point a fan over many flights, and the flight in which it did worst: that with the largest value of the first
objective that counts in the scenario.
"""

from typing import TYPE_CHECKING, Any

import numpy as np

from plant.scenarios import HELD_OUT, ScenarioSpec, sample_scenarios
from tuner.analysis.responses import SIGNALS, UNITS, Responses, fly_responses

if TYPE_CHECKING:
    from tuner.experiments.tuning.outcome import Outcome

# Held-out scenarios a fan is drawn from: its 5 % and 95 % lines rest on three flights each.
FAN_SCENARIOS = 64


def response_table(outcome: "Outcome") -> Any:
    """Fly every finalist through held-out scenarios and return the fans as one long pandas table.

    A row for each signal and instant: point, scenario, signal, unit, time [s], reference, low, median, high (5, 50, 95 %), worst,
    and worst_flight, the index of that flight among the held-out ones. Values are float32: 31 points take 3 MB a scenario.
    """
    import pandas as pd

    study = outcome.study
    parts = [
        part
        for entry in study.scenarios
        for part in scenario_parts(outcome, entry.spec, min(FAN_SCENARIOS, entry.held_out))
    ]
    table = pd.concat(parts, ignore_index=True)
    return table.astype({name: "category" for name in ("point", "scenario", "signal", "unit")})


def scenario_parts(outcome: "Outcome", spec: ScenarioSpec, count: int) -> list[Any]:
    """Return the tables of all points in one scenario, fans over so many flights."""
    inputs = drawn(outcome, spec, range(count))
    worst = worst_flights(outcome, spec.name)
    parts = []
    for row, name in enumerate(outcome.names):
        flown = flight_of(outcome, row, inputs)
        index = int(worst[row])
        single = (
            flown.actual[index] if index < count else flight_of(outcome, row, drawn(outcome, spec, [index])).actual[0]
        )
        parts.append(point_table(flown, name, spec.name, single, index))
    return parts


def worst_flights(outcome: "Outcome", scenario: str) -> np.ndarray:
    """Return for each finalist the index (rows,) of its worst flight among the held-out ones of a scenario."""
    objectives = outcome.study.objectives
    chosen = next((i for i, entry in enumerate(objectives) if entry.scenario in (None, scenario)), 0)
    return np.argmax(outcome.finalists.evaluation.samples(chosen, scenario), axis=-1)


def drawn(outcome: "Outcome", spec: ScenarioSpec, indices: Any) -> Any:
    """Return held-out flights of a scenario by their indices."""
    system = outcome.study.system
    return sample_scenarios(spec, system.vehicle, system.timing, outcome.study.seed, HELD_OUT, indices)


def flight_of(outcome: "Outcome", row: int, inputs: Any) -> Responses:
    """Return what a finalist does in drawn flights."""
    system = outcome.study.system
    return fly_responses(
        outcome.problem.flyer, outcome.gains(row), system.nominal, inputs, system.timing.control_period
    )


def point_table(flown: Responses, point: str, scenario: str, worst: np.ndarray, index: int) -> Any:
    """Return the fans of one point as a long table (pandas); worst (instants, signals): its worst flight."""
    import pandas as pd

    count, signals = len(flown.time), len(SIGNALS)
    series = {"reference": flown.reference.mean(axis=0)}
    series |= dict(zip(("low", "median", "high"), flown.fans(), strict=True))
    series["worst"] = worst
    columns: dict[str, Any] = {"point": point, "scenario": scenario}
    columns |= {"signal": np.repeat(SIGNALS, count), "unit": np.repeat(UNITS, count)}
    columns["time"] = np.tile(flown.time, signals)
    columns |= {name: values.T.ravel().astype(np.float32) for name, values in series.items()}
    return pd.DataFrame({**columns, "worst_flight": np.int32(index)})
