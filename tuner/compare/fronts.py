"""Fronts of several runs flown again through the same scenarios, so that they can be laid over each other.

A front as a run left it rests on that run's own held-out flights. Its points are flown here once more, and what is no longer
feasible or is dominated on these flights is left out.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from objectives.risk import interval_on, resampled_scenarios, within
from plant.seeds import generator
from tuner.compare.entrants import Entrant
from tuner.contest.contest import Contest
from tuner.contest.flying import Entry, Flown
from tuner.contest.fronts import Front
from tuner.held_out import FRONT_REPLICATES
from tuner.search.front import non_dominated

MOST_POINTS = 40
"""Points of a front that are flown at most; more do not show."""


def thinned(entrant: Entrant, objective: np.ndarray) -> Entrant:
    """Return an entrant with at most `MOST_POINTS` points of its front, evenly along the values (n,) of an objective.

    The point it recommends stays, wherever it lies.
    """
    count = len(entrant.points)
    if count <= MOST_POINTS:
        return entrant
    order = np.argsort(objective, kind="stable")
    kept = set(order[np.linspace(0, count - 1, MOST_POINTS).round().astype(int)].tolist())
    kept |= {i for i, point in enumerate(entrant.points) if point == entrant.point}
    rows = sorted(kept)
    return replace(entrant, points=tuple(entrant.points[i] for i in rows), rows=entrant.rows[rows])


def entries_of(entrant: Entrant, at: Entry) -> list[Entry]:
    """Return an entry for each point of a front; at: the entry of the same controller at its recommended point."""
    return [
        Entry(at.contender, point, row, at.problem) for point, row in zip(entrant.points, entrant.rows, strict=True)
    ]


def front_of(contest: Contest, entries: Sequence[Entry], flown: Flown) -> Front:
    """Return the feasible, non-dominated points among entries of one contender; flown: of these entries alone."""
    objectives = contest.base.objectives
    drawn = resampled_scenarios(generator(contest.seed, "bootstrap/compare-front", 0), FRONT_REPLICATES, flown.origin)
    samples = [flown.samples(i, objective.scenario) for i, objective in enumerate(objectives)]
    values, low, high = (np.empty((len(entries), len(objectives))) for _ in range(3))
    for i, objective in enumerate(objectives):
        values[:, i] = objective.risk.apply(samples[i])
        part = within(drawn, flown.origin, objective.scenario)
        low[:, i], high[:, i] = interval_on(samples[i], objective.risk, part)
    kept = np.flatnonzero(_feasible(contest, flown))
    best = kept[non_dominated(values[kept])]
    return Front(
        points=[entries[k].point for k in best],
        candidates=np.full(len(best), -1),
        gains=np.stack([entry.row for entry in entries])[best],
        values=values[best],
        low=low[best],
        high=high[best],
        samples=[part[best] for part in samples],
    )


def _feasible(contest: Contest, flown: Flown) -> np.ndarray:
    """Return which entries (entries,) keep every constraint on flights."""
    kept = np.ones(len(flown.scores), dtype=bool)
    for i, quantity in enumerate(contest.quantities):
        if quantity.limit is not None:
            kept &= quantity.objective.risk.apply(flown.samples(i, quantity.objective.scenario)) <= quantity.limit
    return kept
