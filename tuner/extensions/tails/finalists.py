"""The estimator of limits on rare events, for runs and their plans."""

from collections.abc import Mapping

import numpy as np

from tuner.documents.plan import PlannedTail
from tuner.experiments.tuning.finalist_limits import FinalistEstimator
from tuner.extensions.tails.estimation.planning import choose_method
from tuner.extensions.tails.limits import MAX_POINTS, FinalistTails, TailLimits, expected_flights, scenarios_of
from tuner.extensions.tails.words import tail_words
from tuner.search.watcher import Watcher
from tuner.study.study import TuningStudy


def finalist_tails(study: TuningStudy, gains: np.ndarray, threads: int | None, watcher: Watcher) -> FinalistTails:
    """Return the finalists' limits; gains (rows, g)."""
    return FinalistTails(TailLimits(study, threads, watcher), gains)


def planned_estimates(study: TuningStudy, flights_per_second: Mapping[str, float]) -> list[PlannedTail]:
    """Return the estimates that the limits of a study ask for; flights_per_second: in its scenarios by name."""
    rows = []
    for limit in study.constraints:
        if limit.is_tail:
            flights, names = expected_flights(limit), [entry.spec.name for entry in scenarios_of(study, limit)]
            rows.append(
                PlannedTail(
                    label=limit.objective.label,
                    limit=limit.most,
                    method=str(choose_method(limit.most)),
                    flights=flights * len(names),
                    seconds=sum(flights / flights_per_second[name] for name in names),
                    points_at_most=MAX_POINTS,
                )
            )
    return rows


ESTIMATOR = FinalistEstimator(finalist_tails, tail_words, planned_estimates)
