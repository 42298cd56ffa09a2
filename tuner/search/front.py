"""Non-dominated candidates, the hypervolume of a front, and the rules that pick a point from it."""

from collections.abc import Mapping
from math import isfinite
from typing import Any

import numpy as np

from plant.errors import InputError, UnknownNameError

# The reference point of the hypervolume, in units of the default gains' values.
REFERENCE = 1.1
# What stands before an objective's name in a rule, and before the weights in a resolved one.
LEAST, WEIGHTED = "min:", "weights:"


def non_dominated(values: np.ndarray) -> np.ndarray:
    """Return a mask (n,) of the rows of values (n, m) that no other row beats in one objective and equals or beats in all.

    Equal rows do not dominate each other.
    """
    if len(values) == 0:
        return np.zeros(0, dtype=bool)
    from moocore import is_nondominated

    return np.asarray(is_nondominated(values, keep_weakly=True))


def evenly(values: np.ndarray, most: int) -> np.ndarray:
    """Return the rows, in increasing order of values (n,), of at most so many of them, evenly chosen along that order."""
    order = np.argsort(values, kind="stable")
    if len(order) <= most:
        return order
    return order[np.unique(np.linspace(0, len(order) - 1, most).round().astype(int))]


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


def thinned(front: np.ndarray, baseline: np.ndarray, most: int, ends: bool = True) -> np.ndarray:
    """Return rows, at most so many, of a front (n, m) that add most hypervolume one after the other, in that order.

    ends: whether those that are best in one objective come first. baseline (m,): see `hypervolume`.
    """
    if len(front) <= most:
        return np.arange(len(front))
    picked = [int(row) for row in dict.fromkeys(front.argmin(axis=0).tolist())][:most] if ends else []
    # What a row adds shrinks with every row picked: the best of those found anew is the best of all.
    adds, fresh = np.full(len(front), np.inf), np.zeros(len(front), dtype=bool)
    reached = hypervolume(front[picked], baseline)
    while len(picked) < most:
        adds[picked] = -np.inf
        best = int(np.argmax(adds))
        if fresh[best]:
            picked.append(best)
            fresh[:], reached = False, hypervolume(front[picked], baseline)
        else:
            adds[best] = hypervolume(front[[*picked, best]], baseline) - reached
            fresh[best] = True
    return np.array(picked, dtype=int)


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
    """Return the row of values (n, m) that a rule picks and why; names: of the objectives.

    rule: as `resolved_rule` returns it.
    """
    if rule in PICKS:
        choose, why = PICKS[rule]
        return choose(values), why
    if rule.startswith(WEIGHTED):
        weights = np.array([float(part) for part in rule.removeprefix(WEIGHTED).split(",")])
        assert len(weights) == values.shape[1], "a resolved rule has a weight for each objective"
        terms = [f"{weight:g} {name}" for weight, name in zip(weights, names, strict=True) if weight > 0.0]
        why = f"it has the smallest weighted sum {' + '.join(terms)} of the objectives scaled to 0 to 1 over the front"
        return int(np.argmin(normalised(values) @ weights)), why
    name = rule.removeprefix(LEAST)
    if not rule.startswith(LEAST) or name not in names:
        raise UnknownNameError("pick rule", rule, [*PICKS, *[f"{LEAST}{entry}" for entry in names]])
    return int(np.argmin(values[:, names.index(name)])), f"it has the smallest {name}"


def resolved_rule(rule: str, weights: Mapping[str, Any], labels: list[str], addresses: list[str]) -> str:
    """Return a pick rule of a study with the objectives spelt out: "min:LABEL", or "weights:2.0,1.0" in their order.

    labels, addresses: of each objective; either may name it. InputError (key "rule" or "weights") where that fails.
    """
    if weights and rule != "weights":
        raise InputError(
            f'given weights beside rule = "{rule}"; write rule = "weights", or leave them out', key="weights"
        )
    if rule in PICKS:
        return rule
    if rule == "weights":
        return WEIGHTED + ",".join(repr(weight) for weight in weights_of(weights, labels, addresses))
    if not rule.startswith(LEAST) or rule.removeprefix(LEAST) not in (*labels, *addresses):
        allowed = [*PICKS, "weights", *[f"{LEAST}{address}" for address in addresses]]
        raise UnknownNameError("pick rule", rule, allowed, key="rule")
    return LEAST + labels[_meant(rule.removeprefix(LEAST), labels, addresses, "rule", LEAST)]


def weights_of(weights: Mapping[str, Any], labels: list[str], addresses: list[str]) -> list[float]:
    """Return the weight of each objective, 0 where none is given; InputError where a key or a number is none."""
    found = [0.0] * len(labels)
    for name, weight in _flat(weights).items():
        key = f"weights.{name}"
        if name not in (*labels, *addresses):
            raise UnknownNameError("objective", name, [*addresses, *labels], key=key)
        if isinstance(weight, bool) or not isinstance(weight, int | float) or not (isfinite(weight) and weight >= 0.0):
            raise InputError(f"given {weight!r}; a weight is a finite number, 0 or more", key=key)
        found[_meant(name, labels, addresses, key)] = float(weight)
    if not any(found):
        raise InputError(
            f'no objective has a weight above 0; write weights = {{ "{addresses[0]}" = 1 }}', key="weights"
        )
    return found


def _flat(weights: Mapping[str, Any]) -> dict[str, Any]:
    """Return itae.position = 2, which TOML reads as a table "itae", under the key "itae.position"."""
    flat: dict[str, Any] = {}
    for name, entry in weights.items():
        inner = {f"{name}.{leaf}": value for leaf, value in entry.items()} if isinstance(entry, Mapping) else {}
        flat |= inner or {name: entry}
    return flat


def _meant(name: str, labels: list[str], addresses: list[str], key: str, before: str = "") -> int:
    """Return the objective that a label or an address names; InputError where an address fits several."""
    if name in labels:
        return labels.index(name)
    found = [i for i, address in enumerate(addresses) if address == name]
    if len(found) > 1:
        choice = " or ".join(f'"{before}{labels[i]}"' for i in found)
        raise InputError(f"given '{before}{name}', which fits {len(found)} objectives; write {choice}", key=key)
    return found[0]
