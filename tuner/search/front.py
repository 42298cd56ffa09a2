"""Which candidates are non-dominated, how much a front is worth, and which point to pick from it."""

import numpy as np

from plant.errors import UnknownNameError

# The reference point of the hypervolume, in units of the default gains' values.
REFERENCE = 1.1


def non_dominated(values: np.ndarray) -> np.ndarray:
    """Return a mask (n,) of the rows of values (n, m) that no other row beats in one objective and equals or beats in all.

    Equal rows do not dominate each other.
    """
    if len(values) == 0:
        return np.zeros(0, dtype=bool)
    from moocore import is_nondominated

    return np.asarray(is_nondominated(values, keep_weakly=True))


def feasible_front(values: np.ndarray, violations: np.ndarray) -> np.ndarray:
    """Return the indices of the feasible, non-dominated rows, duplicates (equal values) once."""
    feasible = np.flatnonzero(np.all(violations <= 0.0, axis=1))
    _, first = np.unique(values[feasible], axis=0, return_index=True)
    feasible = feasible[np.sort(first)]
    return feasible[non_dominated(values[feasible])]


def hypervolume(front: np.ndarray, baseline: np.ndarray) -> float:
    """Return the share of the box from 0 to 1.1 times the baseline (m,) that a front (n, m) dominates.

    Values are never negative, so the box holds all of the front that matters; points beyond it count for nothing.
    """
    if len(front) == 0:
        return 0.0
    from moocore import hypervolume as volume

    scaled = front / np.where(baseline > 0.0, baseline, 1.0)
    return float(volume(scaled, ref=np.full(front.shape[1], REFERENCE))) / REFERENCE ** front.shape[1]


def normalised(values: np.ndarray) -> np.ndarray:
    """Scale each objective of a front (n, m) to [0, 1] between its smallest and largest value."""
    low, high = values.min(axis=0), values.max(axis=0)
    return (values - low) / np.where(high > low, high - low, 1.0)


def knee(values: np.ndarray) -> int:
    """Return the point that lies deepest below the hyperplane through the ends of the front.

    I. Das, "On characterizing the knee of the Pareto curve", Structural Optimization 18:107-115, 1999. On normalised
    objectives that hyperplane is sum = const through the single-objective optima, so the knee has the smallest sum.
    """
    return int(np.argmin(normalised(values).sum(axis=1)))


def closest(values: np.ndarray) -> int:
    """Return the point with the smallest Euclidean distance to the ideal point, on normalised objectives."""
    return int(np.argmin(np.square(normalised(values)).sum(axis=1)))


PICKS = {
    "knee": (knee, "it lies deepest below the line through the ends of the front"),
    "closest": (closest, "it is the closest to the best value of every objective at once"),
}


def pick(rule: str, values: np.ndarray, names: list[str]) -> tuple[int, str]:
    """Return the row of values (n, m) that a rule picks and why; names: what "min:NAME" may ask for, one an objective."""
    if rule in PICKS:
        choose, why = PICKS[rule]
        return choose(values), why
    name = rule.removeprefix("min:")
    if not rule.startswith("min:") or name not in names:
        raise UnknownNameError("pick rule", rule, [*PICKS, *[f"min:{entry}" for entry in names]])
    return int(np.argmin(values[:, names.index(name)])), f"it has the smallest {name}"
