"""Loss of a run's objectives because the vehicle is not known better, and the number to measure next.

From the held-out flights that the finalists have made: each has a vehicle of its own, drawn from the airframe's uncertainty.
"""

from collections.abc import Sequence

import numpy as np

from plant.scenarios import HELD_OUT, ScenarioSpec, drawn_numbers
from plant.seeds import generator
from tuner.analysis.worth import FEWEST, Worth, worths
from tuner.documents.summary import NumberWorth, UncertaintyCost
from tuner.experiments.tuning.outcome import Outcome
from tuner.study.study import Study


def uncertainty_costs(outcome: Outcome) -> list[UncertaintyCost]:
    """Return a row for each objective that flights over an airframe's uncertainty count for; none where there are no such."""
    study = outcome.study
    if not isinstance(study, Study) or not outcome.feasible:
        return []
    found = [_cost(outcome, study, i) for i in range(len(study.objectives))]
    return [row for row in found if row is not None]


def _cost(outcome: Outcome, study: Study, i: int) -> UncertaintyCost | None:
    flown, objective = outcome.finalists.flown, study.objectives[i]
    specs = [entry.spec for entry in study.scenarios if _counts(entry.spec, objective.scenario)]
    rows = np.flatnonzero(flown.complete & outcome.finalists.feasible)
    samples = flown.scores[rows, i][:, np.isin(flown.origin, [spec.name for spec in specs])]
    if len(rows) < 2 or samples.shape[1] < FEWEST:
        return None
    shown, draw = int(np.flatnonzero(rows == outcome.tuned)[0]), generator(study.seed, "worth", i)
    everything, each = worths(samples, _numbers(study, specs, flown.origin), shown, draw)
    mean, (first, *_) = float(np.min(samples.mean(axis=1))), specs
    return UncertaintyCost(
        label=objective.label, unit=objective.metric.unit, finalists=len(rows), flights=samples.shape[1], mean=mean,
        known=mean - everything.value, told=everything.told, share=max(worth.share for worth in (everything, *each)),
        numbers=_ordered(first.uncertainty.names if first.uncertainty else (), each),
    )  # fmt: skip


def _numbers(study: Study, specs: Sequence[ScenarioSpec], origin: np.ndarray) -> np.ndarray:
    """Return what was drawn for the held-out flights of some scenarios (flights, names)."""
    counts = [int(np.sum(origin == spec.name)) for spec in specs]
    vehicle, root = study.system.vehicle, study.seed
    parts = [drawn_numbers(spec, vehicle, root, HELD_OUT, range(n)) for spec, n in zip(specs, counts, strict=True)]
    return np.concatenate(parts)


def _counts(spec: ScenarioSpec, scenario: str | None) -> bool:
    return spec.uncertainty is not None and scenario in (None, spec.name)


def _ordered(names: Sequence[str], each: Sequence[Worth]) -> list[NumberWorth]:
    """Return the numbers, first those that are worth most, then those that explain most."""
    rows = [
        NumberWorth(name=name, value=worth.value, told=worth.told, share=worth.share, shows=worth.shows)
        for name, worth in zip(names, each, strict=True)
    ]
    return sorted(rows, key=lambda row: (-row.value, not row.shows, -row.share))
