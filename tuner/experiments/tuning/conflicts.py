"""Conflicts of limits: which no candidate kept together, how far they would have to be relaxed, and what each costs.

All of it holds for the candidates that a search tried. Of a candidate that was not flown through every scenario the requirements
are known and the constraints are not: it counts as one that does not keep them, and no relaxation is drawn from it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import ceil, floor, log10
from typing import NamedTuple

import numpy as np

from objectives.mission import OFF_KEY
from objectives.plant_mission import REGULATED
from objectives.problem import Constraint
from objectives.requirements import Requirement
from objectives.scales import Scale
from plant.ties import first_smallest
from tuner.documents.plan import AutomaticLimit
from tuner.search.loop import Archive, point_name
from tuner.text.sentences import BOUNDS
from tuner.text.units import after_number

# Smallest conflicting sets told at most: with many, the limits are hopeless one and all.
MAX_SETS = 6


UpperEnd = Callable[[int, int], float]
"""Function of a candidate and of a constraint that returns the least limit which the candidate satisfies."""


class Limit(NamedTuple):
    """A constraint or requirement.

    Attributes:
        sense: "max" or "min".
        flown: Whether a value is available of flown candidates only.
        automatic: Key of the study that moves a limit which it does not write, see `objectives.mission`; else "".
        scale: Scale from the unit of files, see `Requirement`.
    """

    label: str
    unit: str
    sense: str
    limit: float
    flown: bool
    automatic: str = ""
    scale: Scale | None = None

    def relaxed(self, share: float) -> float:
        """Return the limit, given way by a share of its size (of 1 where it is 0)."""
        step = share * (abs(self.limit) or 1.0)
        return self.limit + step if self.sense == "max" else self.limit - step

    @property
    def text(self) -> str:
        """Return "mean(saturation) at most 0.02", of an automatic limit with its key."""
        entries = f"{self.label} {BOUNDS[self.sense]} {number_text(self.limit, self.unit)}"
        source = f"{REGULATED:g} times the default's, {OFF_KEY}" if self.automatic == OFF_KEY else self.automatic
        return f"{entries} (automatic: {source})" if self.automatic else entries


class Relaxation(NamedTuple):
    """Limits that let a candidate in, as (index of the limit, what it would have to be); share: of the largest step."""

    candidate: int
    share: float
    changes: tuple[tuple[int, float], ...]


class LimitPrice(NamedTuple):
    """Best feasible value of an objective with and without one limit."""

    limit: int
    objective: int
    with_limit: float
    without: float


@dataclass(frozen=True)
class Conflict:
    """Limits that no candidate satisfies together.

    None, or nothing: no flown candidate is near enough for a finite step.

    Attributes:
        sets: The smallest sets of limits of which no candidate satisfies all, at most `MAX_SETS`.
        common: The least relaxation of all limits by one share.
        single: The least relaxation of each limit that need only give way alone.
    """

    sets: tuple[tuple[int, ...], ...]
    common: Relaxation | None
    single: tuple[Relaxation, ...]


def limits_of(constraints: Sequence[Constraint], requirements: Sequence[Requirement]) -> list[Limit]:
    """Return all limits in the order of the columns of violations."""
    entries = [Limit(c.objective.label, c.objective.metric.unit, "max", c.most, True, c.floor) for c in constraints]
    return entries + [Limit(r.label, r.unit, r.sense, r.limit, False, scale=r.scale) for r in requirements]


def shares(tried: Archive, limits: Sequence[Limit]) -> np.ndarray:
    """Return the shares by which candidates break limits (n, limits); infinite where not available."""
    is_known = np.array([not limit.flown for limit in limits], dtype=bool) | tried.flown[:, None]
    split = sum(limit.flown for limit in limits)
    scale = np.array([abs(limit.limit) or 1.0 for limit in limits[:split]])
    relative = tried.violations.copy()
    # The violations of requirements are shares already, those of constraints are in the metric's unit.
    relative[:, :split] /= scale
    for i in range(len(limits) - split):
        relative[~np.isfinite(tried.requirements[:, i]) & (relative[:, split + i] > 0.0), split + i] = np.inf
    return np.where(is_known, relative, np.inf)


def conflict_of(tried: Archive, limits: Sequence[Limit], upper_end: UpperEnd | None = None) -> Conflict | None:
    """Return the conflict where no candidate satisfied every limit, else None.

    upper_end: by which a constraint is judged in the end; without it relaxed limits are values of candidates.
    """
    broken = shares(tried, limits)
    if not limits or np.any(np.all(broken <= 0.0, axis=1)):
        return None
    near = np.isfinite(broken).all(axis=1)
    rows = np.flatnonzero(near)
    common = None
    if len(rows):
        common = _relaxation(broken, limits, int(rows[first_smallest(broken[rows].max(axis=1))]), upper_end)
    return Conflict(tuple(conflicting_sets(broken <= 0.0)), common, tuple(_single(broken, limits, upper_end)))


def conflicting_sets(is_met: np.ndarray) -> list[tuple[int, ...]]:
    """Return the smallest sets of columns that no row of `is_met` (n, limits) satisfies; exact, by size, in order."""
    patterns = np.unique(is_met, axis=0)
    for size in range(1, is_met.shape[1] + 1):
        tried = [some for some in combinations(range(is_met.shape[1]), size) if not patterns[:, some].all(axis=1).any()]
        if tried:
            return tried[:MAX_SETS]
    return []


def _single(broken: np.ndarray, limits: Sequence[Limit], upper_end: UpperEnd | None) -> list[Relaxation]:
    tried = []
    for i in range(len(limits)):
        others = np.delete(broken, i, axis=1)
        rows = np.flatnonzero(np.all(others <= 0.0, axis=1) & np.isfinite(broken[:, i]))
        if len(rows):
            tried.append(_relaxation(broken, limits, int(rows[first_smallest(broken[rows, i])]), upper_end))
    return tried


def _relaxation(broken: np.ndarray, limits: Sequence[Limit], candidate: int, upper_end: UpperEnd | None) -> Relaxation:
    row, changes = broken[candidate], list[tuple[int, float]]()
    for i in np.flatnonzero(row > 0.0).tolist():
        value = limits[i].relaxed(float(row[i]))
        if upper_end is not None and limits[i].flown:
            value = max(value, upper_end(candidate, i))
        changes.append((i, value))
    steps = [abs(value - limits[i].limit) / (abs(limits[i].limit) or 1.0) for i, value in changes]
    return Relaxation(candidate, max(steps), tuple(changes))


def costs_of(tried: Archive, limits: Sequence[Limit]) -> list[LimitPrice]:
    """Return the price of each limit in each objective.

    It is the fall of the best value without the limit, where there is one and some candidates are feasible. A hard
    requirement has none: what breaks it was not flown.
    """
    broken = shares(tried, limits)
    feasible = np.all(broken <= 0.0, axis=1) & tried.flown
    if not feasible.any():
        return []
    best = tried.values[feasible].min(axis=0)
    costs = []
    for i in range(len(limits)):
        allowed = np.all(np.delete(broken, i, axis=1) <= 0.0, axis=1) & tried.flown
        without = tried.values[allowed].min(axis=0)
        costs += [LimitPrice(i, m, float(best[m]), float(without[m])) for m in np.flatnonzero(without < best).tolist()]
    return costs


def automatic_rows(automatic: Sequence[Constraint]) -> list[AutomaticLimit]:
    """Return limits that the study does not write as rows."""
    return [
        AutomaticLimit(label=each.label, unit=each.unit, limit=each.limit, key=each.automatic)
        for each in limits_of(automatic, ())
    ]


def automatic_limit_texts(automatic: Sequence[Constraint]) -> list[str]:
    """Return a sentence for each limit that the study does not write."""
    return [f"Automatic limit: {limit.text}." for limit in limits_of(automatic, ())]


def conflict_texts(
    conflict: Conflict,
    limits: Sequence[Limit],
    default: int | None = None,
    command: Callable[[str, str], str] | None = None,
) -> list[str]:
    """Return a conflict in sentences.

    Args:
        conflict: The conflict.
        limits: All limits.
        default: The candidate that is the default, None where it was not searched.
        command: Function of a key and a value that returns the command which judges by another limit.
    """
    # Of a limit that is kept by nobody alone an obstacle tells.
    texts = [_sets_text(conflict, limits)] if len(conflict.sets[0]) > 1 else []
    if conflict.common is None:
        return [*texts, "No flown candidate is within a finite step of the limits; widen the ranges of the gains."]
    for relaxation in sorted(conflict.single, key=lambda entry: entry.share):
        texts.append(_single_text(relaxation, limits, default, command))
    if not conflict.single and conflict.common.candidate != default:
        texts.append(
            f"All of these together would let {_named(conflict.common, default)} in: {_steps(conflict.common, limits)}."
        )
    return texts


def _single_text(
    relaxation: Relaxation,
    limits: Sequence[Limit],
    default: int | None,
    command: Callable[[str, str], str] | None,
) -> str:
    text = f"{_steps(relaxation, limits)} alone would let {_named(relaxation, default)} in"
    ((i, value),) = relaxation.changes
    # An automatic limit is a share of an error that the key does not tell.
    if command is None or not limits[i].flown or limits[i].automatic:
        return f"{text}."
    return f"{text}: `{command(f'constraint.{i}.max', _rounded_outward(value, limits[i]))}`."


def _named(relaxation: Relaxation, default: int | None) -> str:
    point = point_name(relaxation.candidate)
    return f"{point}, the default itself," if relaxation.candidate == default else point


def _sets_text(conflict: Conflict, limits: Sequence[Limit]) -> str:
    sets = [" and ".join(limits[i].text for i in some) for some in conflict.sets]
    return f"Kept together by none of them: {'; or '.join(sets)}."


def _steps(relaxation: Relaxation, limits: Sequence[Limit]) -> str:
    steps = [
        f"{limits[i].label} {number_text(limits[i].limit, limits[i].unit)} -> {_towards(value, limits[i])}"
        for i, value in relaxation.changes
    ]
    return ", ".join(steps)


def _towards(value: float, limit: Limit) -> str:
    """Return a relaxed limit as text, rounded to admit the candidate."""
    return f"{_rounded_outward(value, limit)}{after_number(limit.unit)}"


def _rounded_outward(value: float, limit: Limit) -> str:
    if value == 0.0:
        return "0"
    step = 10.0 ** (floor(log10(abs(value))) - 3)
    return f"{(ceil if limit.sense == 'max' else floor)(value / step) * step:.4g}"


def cost_texts(
    costs: Sequence[LimitPrice], limits: Sequence[Limit], labels: Sequence[str], units: Sequence[str]
) -> list[str]:
    """Return sentences on the price of each limit; labels, units: of the objectives."""
    texts = []
    for i in dict.fromkeys(cost.limit for cost in costs):
        parts = [
            f"{number_text(cost.without, units[cost.objective])} instead of "
            f"{number_text(cost.with_limit, units[cost.objective])} in {labels[cost.objective]}"
            for cost in costs
            if cost.limit == i
        ]
        texts.append(f"Without {limits[i].text} the front of the search reaches {' and '.join(parts)}.")
    return texts


def number_text(value: float, unit: str) -> str:
    """Return a number to four significant digits with its unit."""
    return f"{value:.4g}{after_number(unit)}"
