"""Fronts of several runs flown again through the same scenarios, so that they can be laid over each other.

A front as a run left it rests on that run's own held-out flights; its points are flown here once more.
"""

from dataclasses import replace

import numpy as np

from tuner.experiments.compare.entrants import Entrant
from tuner.experiments.contest.flying import Entry

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
    return replace(
        entrant, points=tuple(entrant.points[i] for i in rows), rows=entrant.rows[rows], picked=entrant.picked[rows]
    )


def entries_of(entrant: Entrant, at: Entry, same_flights: bool) -> list[Entry]:
    """Return an entry for each point of a front; at: the entry of the same controller at its recommended point.

    same_flights: whether its run flew what is flown here, so that its held-out values are values of the same thing.
    """
    return [
        replace(at, point=point, row=row, picked=values if same_flights else None)
        for point, row, values in zip(entrant.points, entrant.rows, entrant.picked, strict=True)
    ]
