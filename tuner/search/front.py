"""Non-dominated candidates, a front's hypervolume, and rules to pick its points."""

from collections.abc import Mapping
from math import isfinite

import numpy as np

from plant.errors import InputError, UnknownNameError
from plant.texts import PlainTable, PlainValue
from plant.ties import TIE, first_largest, first_smallest

# The reference point of the hypervolume, in units of the default gains' values.
REFERENCE = 1.1
# Largest size of a value in comparisons; an infinite one counts as this. With infinite values of three objectives moocore 0.3.2
# names wrong rows, or ends the process.
MAX_SIZE = 1e300
# Ratio of an objective's ends from which on its logarithm counts. On a hyperbola over a factor of 10 logarithms leave no
# knee at all, and a third more flights to find it; over a factor of 1,500 the natural scale sees one end alone.
WIDE = 30.0
# What stands before an objective's name in a rule, and before the weights in a resolved one.
SMALLEST, WEIGHTED = "min:", "weights:"


def non_dominated(values: np.ndarray) -> np.ndarray:
    """Return a mask (n,) of the non-dominated rows of values (n, m); equal rows do not dominate each other."""
    if len(values) == 0:
        return np.zeros(0, dtype=bool)
    from moocore import is_nondominated

    return np.asarray(is_nondominated(np.clip(values, -MAX_SIZE, MAX_SIZE), keep_weakly=True))


def feasible_front(values: np.ndarray, violations: np.ndarray) -> np.ndarray:
    """Return the indices of the feasible, non-dominated rows, duplicates (equal values) once."""
    feasible = np.flatnonzero(np.all(violations <= 0.0, axis=1))
    _, first = np.unique(values[feasible], axis=0, return_index=True)
    feasible = feasible[np.sort(first)]
    return feasible[non_dominated(values[feasible])]


def hypervolume(front: np.ndarray, baseline: np.ndarray) -> float:
    """Return the dominated share of a box: from 0 to 1.1 times the baseline.

    front (n, m), baseline (m,): never negative; points beyond the box count for nothing.
    """
    if len(front) == 0:
        return 0.0
    from moocore import hypervolume as volume

    scaled = front / np.where(baseline > 0.0, baseline, 1.0)
    return float(volume(scaled, ref=np.full(front.shape[1], REFERENCE))) / REFERENCE ** front.shape[1]


def select_subset(front: np.ndarray, baseline: np.ndarray, most: int, ends: bool = True) -> np.ndarray:
    """Return at most so many rows of a front: chosen greedily by hypervolume, in that order.

    Args:
        front: objectives (n, m) of the points.
        baseline: see `hypervolume`.
        most: largest number of rows.
        ends: the best points of each objective come first.
    """
    if len(front) <= most:
        return np.arange(len(front))
    picked = list(dict.fromkeys(first_smallest(column) for column in front.T))[:most] if ends else []
    # Improvements only shrink with every row picked: the best of those evaluated anew is the best of all.
    improvements, fresh = np.full(len(front), np.inf), np.zeros(len(front), dtype=bool)
    volume = hypervolume(front[picked], baseline)
    while len(picked) < most:
        improvements[picked] = -np.inf
        best = first_largest(improvements)
        if fresh[best]:
            picked.append(best)
            fresh[:], volume = False, hypervolume(front[picked], baseline)
        else:
            improvements[best] = hypervolume(front[[*picked, best]], baseline) - volume
            fresh[best] = True
    return np.array(picked, dtype=int)


def normalize(values: np.ndarray) -> np.ndarray:
    """Return objectives (n, m) of a front, each scaled to [0, 1]."""
    low, high = values.min(axis=0), values.max(axis=0)
    return (values - low) / np.where(high > low, high - low, 1.0)


def is_wide(values: np.ndarray) -> np.ndarray:
    """Return the mask (m,) of the wide objectives of a front.

    They are positive and span more than a factor of `WIDE`; values (n, m).
    """
    low, high = values.min(axis=0), values.max(axis=0)
    return (low > 0.0) & (high > WIDE * low)


def scaled(values: np.ndarray) -> np.ndarray:
    """Return objectives (n, m) of a front, each scaled to [0, 1]: logarithms of those that are wide."""
    wide = is_wide(values)
    return normalize(np.where(wide, np.log(np.where(wide, values, 1.0)), values))


def knee(values: np.ndarray) -> int:
    """Return the row of the knee: deepest below the hyperplane through the ends of the front.

    I. Das, "On characterizing the knee of the Pareto curve", Structural Optimization 18:107-115, 1999. On normalized
    objectives that hyperplane is sum = const through the single-objective optima, so the knee has the smallest sum.
    On logarithms a power law is flat, so its noise decides, and one point beyond an end moved the knee by a factor of
    68,000. The point closest to the ideal moves by at most 6 there, so it is taken on a wide front.
    """
    return closest(values) if is_wide(values).any() else first_smallest(normalize(values).sum(axis=1), scale=1.0)


def closest(values: np.ndarray) -> int:
    """Return the row closest to the ideal point: in Euclidean distance, on normalized objectives."""
    return first_smallest(np.square(scaled(values)).sum(axis=1), scale=1.0)


TIED = {
    "knee": "two points have no knee",
    "closest": "two points are equally close to the best value of every objective at once",
}
PICKS = {
    "knee": (knee, "knee of the held-out front"),
    "closest": (closest, "point of the held-out front closest to the best value of every objective at once"),
}


def is_tied(values: np.ndarray) -> bool:
    """Return True for two points (2, m) that `PICKS` cannot tell apart."""
    return len(values) == 2 and bool(np.ptp(scaled(values).sum(axis=1)) <= TIE)


def pick(rule: str, values: np.ndarray, names: list[str]) -> tuple[int, str]:
    """Return the row of values (n, m) that a rule picks and why; names: of the objectives.

    rule: as `resolved_rule` returns it.
    """
    if rule in PICKS:
        if is_tied(values):
            return first_smallest(values[:, 0]), f"{TIED[rule]}, so the one with the smaller {names[0]} is taken"
        choose, why = PICKS[rule]
        return choose(values), why
    if rule.startswith(WEIGHTED):
        weights = np.array([float(part) for part in rule.removeprefix(WEIGHTED).split(",")])
        assert len(weights) == values.shape[1], "a resolved rule has a weight for each objective"
        terms = [f"{weight:g} {name}" for weight, name in zip(weights, names, strict=True) if weight > 0.0]
        why = f"smallest weighted sum {' + '.join(terms)} of the objectives, scaled to 0 to 1 over the front"
        return first_smallest(normalize(values) @ weights, scale=float(weights.sum())), why
    name = rule.removeprefix(SMALLEST)
    if not rule.startswith(SMALLEST) or name not in names:
        raise UnknownNameError("pick rule", rule, [*PICKS, *[f"{SMALLEST}{objective}" for objective in names]])
    return first_smallest(values[:, names.index(name)]), f"smallest {name}"


def resolved_rule(rule: str, weights: Mapping[str, PlainValue], labels: list[str], addresses: list[str]) -> str:
    """Return a pick rule of a study with the objectives spelt out: "min:LABEL", or "weights:2.0,1.0" in their order.

    labels, addresses: of each objective; either may name it. InputError (key "rule" or "weights") where that fails.
    """
    if weights and rule != "weights":
        raise InputError(
            f'given weights with rule = "{rule}"; write rule = "weights", or leave them out', key="weights"
        )
    if rule in PICKS:
        return rule
    if rule == "weights":
        return WEIGHTED + ",".join(repr(weight) for weight in weights_of(weights, labels, addresses))
    if not rule.startswith(SMALLEST) or rule.removeprefix(SMALLEST) not in (*labels, *addresses):
        allowed = [*PICKS, "weights", *[f"{SMALLEST}{address}" for address in addresses]]
        raise UnknownNameError("pick rule", rule, allowed, key="rule")
    return SMALLEST + labels[_objective_index(rule.removeprefix(SMALLEST), labels, addresses, "rule", SMALLEST)]


def weights_of(weights: Mapping[str, PlainValue], labels: list[str], addresses: list[str]) -> list[float]:
    """Return the weight of each objective, 0 by default; InputError for an invalid key or number."""
    given = values_by_objective(weights, labels, addresses, "weights", "weight")
    if not any(given.values()):
        raise InputError(
            f'no objective has a weight above 0; write weights = {{ "{addresses[0]}" = 1 }}', key="weights"
        )
    return [given.get(index, 0.0) for index in range(len(labels))]


def values_by_objective(
    values: Mapping[str, PlainValue], labels: list[str], addresses: list[str], table: str, noun: str
) -> dict[int, float]:
    """Return numbers of a study's table by the index of their objective.

    Args:
        values: Numbers by label or address of an objective.
        labels: Labels of the objectives.
        addresses: Their metrics.
        table: Key of the table.
        noun: Name of such a number.

    Raises:
        InputError: For an unknown or ambiguous objective, or a number that is not finite or below 0.
    """
    given: dict[int, float] = {}
    for name, value in _flat(values).items():
        key = f"{table}.{name}"
        if name not in (*labels, *addresses):
            raise UnknownNameError("objective", name, [*addresses, *labels], key=key)
        if isinstance(value, bool) or not isinstance(value, int | float) or not (isfinite(value) and value >= 0.0):
            raise InputError(f"given {value!r}; a {noun} is a finite number, 0 or more", key=key)
        given[_objective_index(name, labels, addresses, key)] = float(value)
    return given


def _flat(weights: Mapping[str, PlainValue]) -> PlainTable:
    """Return nested tables as flat keys: TOML reads itae.position = 2 as a table "itae"."""
    flat: PlainTable = {}
    for name, entry in weights.items():
        inner = {f"{name}.{leaf}": value for leaf, value in entry.items()} if isinstance(entry, Mapping) else {}
        flat |= inner or {name: entry}
    return flat


def _objective_index(name: str, labels: list[str], addresses: list[str], key: str, before: str = "") -> int:
    """Return the index of an objective named by label or address; InputError where ambiguous."""
    if name in labels:
        return labels.index(name)
    matches = [i for i, address in enumerate(addresses) if address == name]
    if len(matches) > 1:
        choice = " or ".join(f'"{before}{labels[i]}"' for i in matches)
        raise InputError(f"given '{before}{name}', which fits {len(matches)} objectives; write {choice}", key=key)
    return matches[0]
