"""Precision of a run's figures, estimated from the flights of a pilot.

It gives the widths of a run's 95 % intervals, and the scenarios that a difference takes. The pilot's flights represent
all that could be drawn. A few sets of as many flights as the run has are drawn from them, each scenario in the share
that it has in the run, and each gets the interval that the run would report of it: the median of their widths is the
one to expect. It goes with 1/sqrt(n), but holds for a tail of few flights too, where that does not yet.

P. J. Bickel, F. Goetze, W. R. van Zwet, "Resampling fewer than n observations", Statistica Sinica 7(1):1-31, 1997. The number of
scenarios for a difference d is that of a two-sided test at 5 % that finds it in 80 of 100 cases, n = ((z_.975 + z_.80) s / d)^2
(J. M. Lachin, Controlled Clinical Trials 2(2):93-113, 1981), with s / sqrt(n) the standard deviation of the paired difference.
"""

from math import ceil

import numpy as np

from objectives.problem import Objective
from objectives.risk import Risk, bound_rank, flights_to_bound, minimum_samples
from plant.seeds import generator
from tuner.documents.plan import PlannedBound, PlannedObjective, StreamFlights, StreamWidths
from tuner.experiments.planning.pilot import Pilot
from tuner.study.certainty import CONFIDENCE
from tuner.study.study import TuningStudy

Array = np.ndarray
STREAMS = SEARCH, HELD_OUT = "search", "held_out"
REPLICATES, SETS = 400, 9
# How often the flight with the smallest weight counts where weights differ.
PARTS = 10
# Standard normal quantiles of 97.5 % and of 80 %.
POWER = 1.959964 + 0.841621
# No resample holds anything worse than the worst flight seen, so nothing can be said about the worst case.
WITHOUT_WIDTH = "worst"


def planned_objective(study: TuningStudy, pilot: Pilot, index: int, share: float) -> PlannedObjective:
    """Return the expected precision of objective `index`; share: the difference to detect, relative to the default's value.

    Widths are of the default's interval, null if unknown; scenarios needed tell that difference from the default,
    the median over the pilot's candidates.
    """
    objective = study.objectives[index]
    flights: dict[str, int] = {}
    widths: dict[str, float | None] = {}
    for stream in STREAMS:
        counts = counts_of(study, objective, stream)
        flights[stream] = sum(counts)
        draw = generator(study.seed, f"plan/{stream}", index)
        widths[stream] = width(*pooled(pilot, index, counts), objective, flights[stream], draw)
    scores, weights = pooled(pilot, index, counts_of(study, objective, HELD_OUT))
    default = float(weighed_risk(scores[:1], weights, objective.risk)[0])
    draw = generator(study.seed, "plan/difference", index)
    return PlannedObjective(
        label=objective.label,
        unit=objective.metric.unit,
        default=default,
        flights=StreamFlights(**flights),
        width=StreamWidths(**widths),
        width_percent=StreamWidths(**{stream: percent_of(widths[stream], default) for stream in STREAMS}),
        scenarios_needed=scenarios_needed(scores, pilot.complete, weights, objective.risk, share, draw),
    )


def planned_bounds(study: TuningStudy) -> list[PlannedBound]:
    """Return the bounds of quantiles that held-out flights show."""
    wanted = [*study.objectives, *(limit.objective for limit in study.constraints if not limit.floor)]
    return [
        _bound(study, entry, entry.risk.level) for entry in wanted if entry.risk.name == "quantile" and entry.risk.level
    ]


def _bound(study: TuningStudy, objective: Objective, level: float) -> PlannedBound:
    confidence = study.table.confidence or CONFIDENCE
    flights = sum(counts_of(study, objective, HELD_OUT))
    needed, rank = flights_to_bound(level, confidence), bound_rank(flights, level, confidence)
    return PlannedBound(
        label=objective.label,
        level=level,
        confidence=confidence,
        flights=flights,
        flights_needed=needed,
        rank=rank,
    )


def percent_of(width: float | None, value: float) -> float | None:
    """Return a width in percent of a value, or None."""
    return None if width is None or value == 0.0 else 100.0 * width / abs(value)


def counts_of(study: TuningStudy, objective: Objective, stream: str) -> list[int]:
    """Return each scenario's number of flights that count for an objective."""
    return [getattr(entry, stream) if objective.scenario in (None, entry.spec.name) else 0 for entry in study.scenarios]


def pooled(pilot: Pilot, index: int, counts: list[int]) -> tuple[Array, Array]:
    """Return the pilot's scores (p, n) and flight probabilities in the run (n,); without scenarios of count 0."""
    seen = [(entry.scores[:, index], count) for entry, count in zip(pilot.scenarios, counts, strict=True) if count]
    weights = np.concatenate([np.full(part.shape[1], count / part.shape[1]) for part, count in seen])
    return np.concatenate([part for part, _ in seen], axis=1), weights / weights.sum(axis=0)


def weighed_risk(scores: Array, weights: Array, risk: Risk) -> Array:
    """Return the risks (p,) of weighted scores (p, n), to within 5 %."""
    often = weights / weights.min(axis=0)
    times = np.ones(len(weights)) if np.allclose(often, 1.0) else np.round(PARTS * often)
    return risk.apply(np.repeat(scores, times.astype(int), axis=1))


def width(scores: Array, weights: Array, objective: Objective, count: int, draw: np.random.Generator) -> float | None:
    """Return the width of the default's 95 % interval over `count` flights; scores (p, n), weights (n,).

    None for the worst case, and where too few flights are in the tail: an interval of those is far too narrow.
    """
    if objective.risk.name == WITHOUT_WIDTH or count < minimum_samples(objective.risk):
        return None
    sets = scores[0][draw.choice(scores.shape[1], size=(SETS, count), p=weights)]
    low, high = objective.interval(sets, draw.integers(count, size=(REPLICATES, count), dtype=np.intp))
    return float(np.median(high - low, axis=0))


def scenarios_needed(
    scores: Array, complete: Array, weights: Array, risk: Risk, share: float, draw: np.random.Generator
) -> int | None:
    """Return the flights needed to detect a relative difference to the default; row 0 of scores (p, n).

    The median over the candidates that lost no flight, each scaled to the default's value: a difference is hard to tell between
    candidates about as good as each other, and a bad one is spread as widely as it is bad. None where the default lost a flight,
    no other completed all or a value is 0. A candidate nearer to the default shares more of its luck and needs fewer.
    """
    others = 1 + np.flatnonzero(complete[1:])
    values = weighed_risk(scores[[0, *others]], weights, risk)
    if risk.name == WITHOUT_WIDTH or not complete[0] or not len(others) or np.any(values == 0.0):
        return None
    default = float(values[0])
    n = scores.shape[1]
    chosen = draw.choice(n, size=(REPLICATES, n), p=weights)
    against = risk.apply(scores[0][chosen])
    scales = default / values[1:]
    deviations = [
        _deviation(scores[i][chosen], against, risk, float(scale)) for i, scale in zip(others, scales, strict=True)
    ]
    spread = float(np.median(deviations, axis=0)) * n**0.5
    return max(ceil((POWER * spread / (share * abs(default))) ** 2), minimum_samples(risk))


def _deviation(resampled: Array, against: Array, risk: Risk, scale: float) -> float:
    """Return the standard deviation of a risk difference over resamples: scaled candidate (r, n) minus default (r,)."""
    return float(np.std(scale * risk.apply(resampled) - against, axis=0))
