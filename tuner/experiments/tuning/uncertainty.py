"""Loss from the vehicle's uncertainty, and the number to measure next.

The loss is that of a run's objectives, from the held-out flights that the finalists have made: each has a vehicle of
its own, drawn from the airframe's uncertainty.
"""

from collections.abc import Sequence

import numpy as np

from plant.quadrotor.scenarios import HELD_OUT
from plant.seeds import generator
from tuner.analysis.value_of_information import MIN_FLIGHTS, ValueOfInformation, values_of_information
from tuner.documents.summary import NumberWorth, UncertaintyCost
from tuner.experiments.tuning.outcome import Outcome


def uncertainty_costs(outcome: Outcome) -> list[UncertaintyCost]:
    """Return a row for each objective whose flights vary the airframe; none where there are no such."""
    study = outcome.study
    rows = [_cost(outcome, i) for i in range(len(study.objectives))] if outcome.feasible else []
    return [row for row in rows if row is not None]


def _cost(outcome: Outcome, i: int) -> UncertaintyCost | None:
    study, flown = outcome.study, outcome.finalists.flown
    objective = study.objectives[i]
    specs, numbers = [], []
    for k, entry in enumerate(study.scenarios):
        if objective.scenario in (None, entry.spec.name):
            drawn = study.drawn_numbers(k, HELD_OUT, int(np.sum(flown.origin == entry.spec.name)))
            if drawn is not None:
                specs.append(entry.spec)
                numbers.append(drawn)
    rows = np.flatnonzero(flown.complete & outcome.finalists.feasible)
    samples = flown.scores[rows, i][:, np.isin(flown.origin, [spec.name for spec in specs])]
    if len(rows) < 2 or samples.shape[1] < MIN_FLIGHTS:
        return None
    shown, draw = int(np.flatnonzero(rows == outcome.tuned)[0]), generator(study.seed, "worth", i)
    everything, each = values_of_information(samples, np.concatenate(numbers), shown, draw)
    mean, (first, *_) = float(np.min(samples.mean(axis=1))), specs
    return UncertaintyCost(
        label=objective.label,
        unit=objective.metric.unit,
        finalists=len(rows),
        flights=samples.shape[1],
        mean=mean,
        known=mean - everything.value,
        told=everything.is_significant,
        share=max(estimate.share for estimate in (everything, *each)),
        numbers=_ordered(first.uncertainty.names if first.uncertainty else (), each),
    )


def _ordered(names: Sequence[str], each: Sequence[ValueOfInformation]) -> list[NumberWorth]:
    """Return the numbers in order of value, then of share explained."""
    rows = [
        NumberWorth(
            name=name,
            value=estimate.value,
            told=estimate.is_significant,
            share=estimate.share,
            shows=estimate.is_share_significant,
        )
        for name, estimate in zip(names, each, strict=True)
    ]
    return sorted(rows, key=lambda row: (-row.value, not row.shows, -row.share))
