"""What only the results of a run show. Each function takes plain numbers and returns sentences, none where all is well."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from objectives.risk import percentile_interval
from tuner.contest.bounds import OnBound

# Objectives that differ by less than this share of their size are constant; rank correlations from here on are perfect.
SAME, PERFECT = 1e-9, 0.999
# Candidates from which on a perfect correlation is no accident: ten ranks agree by chance once in 3.6 million.
ENOUGH = 10


def constant_objectives(labels: Sequence[str], values: np.ndarray) -> list[str]:
    """Warn of objectives whose values (n, objectives) are the same for all candidates flown."""
    if len(values) < 2:
        return []
    spread, size = np.ptp(values, axis=0), np.abs(values).max(axis=0)
    return [
        f"{label} is the same for all {len(values)} candidates flown: no gain that is searched moves it. Leave it out, or "
        f"search a gain that does."
        for label, wide, large in zip(labels, spread, size, strict=True)
        if wide <= SAME * large
    ]


def correlated_objectives(labels: Sequence[str], values: np.ndarray) -> list[str]:
    """Warn of pairs of objectives that rank all candidates flown, values (n, objectives), alike."""
    if len(values) < ENOUGH:
        return []
    from scipy.stats import rankdata

    ranks = rankdata(values, axis=0)
    ranks -= ranks.mean(axis=0)
    length = np.sqrt(np.square(ranks).sum(axis=0))
    return [
        f"{labels[i]} and {labels[j]} rank all {len(values)} candidates flown alike, so there is nothing to trade between "
        f"them. Leave one out."
        for i, j in combinations(range(len(labels)), 2)
        if length[i] > 0.0 and length[j] > 0.0 and ranks[:, i] @ ranks[:, j] >= PERFECT * length[i] * length[j]
    ]


def duplicate_knees(names: Sequence[str], tuned: int, rows: Sequence[int], replicates: np.ndarray) -> list[str]:
    """Warn where other points of the front cannot be told from the recommended one.

    names: of all finalists; rows: those on the front; replicates (finalists, objectives, resamples): paired. Two points are told
    apart if the 95 % interval of their difference leaves out 0 in any objective.
    """
    alike = []
    for row in rows:
        low, high = percentile_interval(replicates[row] - replicates[tuned])
        if row != tuned and np.all((low <= 0.0) & (high >= 0.0), axis=0):
            alike.append(names[row])
    if not alike:
        return []
    others = ", ".join(alike[:3]) + (f" and {len(alike) - 3} more" if len(alike) > 3 else "")
    return [
        f"{names[tuned]} cannot be told from {others}: they differ by less than the 95 % intervals in every objective. "
        f"Any of them may be taken; raise held_out to tell them apart."
    ]


def gains_on_bounds(found: Sequence[OnBound]) -> list[str]:
    """Warn of recommended gains that ended at an end of their range that could be moved."""
    return [
        f"{entry.variable} = {entry.value:.4g} stands at the {entry.end} end of its range, {entry.bound:.4g}, as do "
        f"{100.0 * entry.share:.0f} % of the front: the range decided, not the search. Widen it there, if the vehicle allows."
        for entry in found
        if entry.recommended and not entry.natural
    ]


def idle_candidates(idle: int, floor: Sequence[str]) -> list[str]:
    """Say how many candidates kept everything but the mission floor."""
    if idle == 0:
        return []
    word = "candidate" if idle == 1 else "candidates"
    return [
        f"{idle} {word} kept every other limit without flying the mission, and counted as infeasible: {', '.join(floor)}."
    ]
