"""Requirements on a controller that are known without flying it: bounds that theory gives, stability margins.

An analysis turns gains into numbers, a requirement puts a limit on one of them. A candidate that violates a hard one does not
fly; a soft one is flown and counts as a broken constraint. `Problem` asks before it flies.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from objectives.scales import Scale, in_file, units_of

Array = NDArray[np.float64]

LARGEST_VIOLATION = 1e6
"""Largest count of a violation, in limits: an infinite value must not hide the other violations of a candidate."""


@dataclass(frozen=True)
class Requirement:
    """One number for each candidate, with a limit.

    Attributes:
        label: short name, unique in a study.
        quantity: what the number is, one line for reports.
        unit: unit of value and limit, as a study file gives it.
        limit: finite.
        sense: "max", the value must not exceed the limit, or "min", not fall below it.
        hard: whether a candidate that breaks it is left unflown.
        scale: from the SI unit of files to `unit`, None where files hold `unit`.
    """

    label: str
    quantity: str
    unit: str
    limit: float
    sense: str
    hard: bool = True
    scale: Scale | None = None

    def __post_init__(self) -> None:
        assert self.sense in ("max", "min") and isfinite(self.limit), "a requirement comes from a checked study"

    def units(self) -> dict[str, str]:
        """Return the unit in files and the unit in reports."""
        return units_of(self.unit, self.scale)

    def in_file(self, value: Any) -> Any:
        """Return a value in the unit of files."""
        return in_file(value, self.scale)

    def excess(self, values: Array) -> Array:
        """Return the excess of values (n,) over the limit: relative to |limit|, or to 1 if it is 0; below 0 if satisfied."""
        beyond = values - self.limit if self.sense == "max" else self.limit - values
        return np.clip(beyond / (abs(self.limit) or 1.0), -LARGEST_VIOLATION, LARGEST_VIOLATION)

    def violations(self, values: Array) -> Array:
        """Return the violation of values (n,), as `excess`, 0 where satisfied."""
        return np.maximum(self.excess(values), 0.0)

    def is_satisfied(self, values: Array) -> NDArray[np.bool_]:
        """Return True where values (n,) satisfy the limit."""
        return self.violations(values) <= 0.0


Analysis = Callable[[Array], Array]
"""Function of gains rows (n, gains) that returns values (n, requirements): never NaN, infinite only where documented."""


@dataclass(frozen=True)
class Screen:
    """Requirements that one analysis answers together.

    Attributes:
        analyse: the analysis that every candidate meets.
        further: a longer one of the same requirements in other states, for candidates that keep every hard one so
            far; the worse value counts.
        complete: one of all states, for the points that a study ends with.
        states, by_state: names of all states, and a function of gains rows (n, gains) that returns the values
            (states, n, requirements) in each.

    The last three go together.
    """

    requirements: tuple[Requirement, ...]
    analyse: Analysis
    further: Analysis | None = None
    complete: Analysis | None = None
    states: tuple[str, ...] = ()
    by_state: Analysis | None = None


ALIKE = 1e-7
"""Relative difference of values that are alike: states that a vehicle's symmetry makes equal differ by rounding, up to 3e-9."""


class WorstState(NamedTuple):
    """The worst state of a candidate's requirement, and the values (states,) in all."""

    name: str
    states: tuple[str, ...]
    values: Array


def requirements_of(screens: tuple[Screen, ...]) -> tuple[Requirement, ...]:
    """Return the requirements of all screens, as the columns of `known_values`."""
    return tuple(requirement for screen in screens for requirement in screen.requirements)


def known_values(screens: tuple[Screen, ...], gains: Array, complete: bool = False) -> Array:
    """Return the values (n, requirements) of all screens for gains rows (n, gains).

    complete: in all states; otherwise a candidate that breaks a hard requirement has its value in the first ones.
    """
    if complete:
        return _answers(screens, gains, lambda screen: screen.complete or screen.analyse)
    values = first_values(screens, gains)
    requirements = requirements_of(screens)
    rows = np.flatnonzero(worth_flying(requirements, values))
    if len(rows) and any(screen.further for screen in screens):
        both = np.stack([values[rows], further_values(screens, gains[rows])])
        values[rows] = worst_value(requirements, both)
    return values


def worst_states(screens: tuple[Screen, ...], row: Array) -> dict[str, WorstState]:
    """Return the worst states of a gains row (gains,) by requirement label."""
    worst = {}
    for screen in screens:
        values = np.empty((0,)) if screen.by_state is None else screen.by_state(row[None])[:, 0]
        for i, requirement in enumerate(screen.requirements if len(values) > 1 else ()):
            column = values[:, i]
            at = worst_place(column, requirement.sense)
            worst[requirement.label] = WorstState(screen.states[at], screen.states, column)
    return worst


def worst_place(values: Array, sense: str) -> int:
    """Return the index of the worst of values (states,).

    Of values that are alike it is the first.
    """
    sizes = values if sense == "max" else -values
    return int(np.argmax(np.isclose(sizes, sizes.max(), rtol=ALIKE, atol=0.0, equal_nan=True)))


def worst_value(requirements: tuple[Requirement, ...], values: Array) -> Array:
    """Return the worst over states of values (states, n, requirements)."""
    least = np.array([entry.sense == "min" for entry in requirements], dtype=bool)
    return np.where(least, values.min(axis=0), values.max(axis=0))


def first_values(screens: tuple[Screen, ...], gains: Array) -> Array:
    """Return the values (n, requirements) of the analyses that every candidate meets."""
    return _answers(screens, gains, lambda screen: screen.analyse)


def further_values(screens: tuple[Screen, ...], gains: Array) -> Array:
    """Return the values (n, requirements) of the longer analyses; of a screen without one the best value there is."""
    return _answers(screens, gains, lambda screen: screen.further or _best_of(screen))


def _best_of(screen: Screen) -> Analysis:
    best = [np.inf if entry.sense == "min" else -np.inf for entry in screen.requirements]
    return lambda gains: np.tile(best, (len(gains), 1))


def _answers(screens: tuple[Screen, ...], gains: Array, analysis: Callable[[Screen], Analysis]) -> Array:
    parts = [np.empty((len(gains), 0))]
    for screen in screens:
        values = analysis(screen)(gains)
        expected = (len(gains), len(screen.requirements))
        assert values.shape == expected, f"an analysis returned {values.shape} for {expected}"
        assert not np.isnan(values).any(), "an analysis returned NaN"
        parts.append(values)
    return np.concatenate(parts, axis=1)


def requirement_excess(requirements: tuple[Requirement, ...], values: Array) -> Array:
    """Return the excess (n, requirements) of values (n, requirements): below 0 where there is slack."""
    excess = np.zeros_like(values)
    for i, requirement in enumerate(requirements):
        excess[:, i] = requirement.excess(values[:, i])
    return excess


def hard_excess(requirements: tuple[Requirement, ...], values: Array) -> Array:
    """Return the excess (n, h) over each hard requirement; a candidate is worth a flight where none is above 0."""
    hard = [entry.excess(values[:, i]) for i, entry in enumerate(requirements) if entry.hard]
    return np.stack(hard, axis=1) if hard else np.empty((len(values), 0))


def worth_flying(requirements: tuple[Requirement, ...], values: Array) -> NDArray[np.bool_]:
    """Return the candidates (n,) that keep every hard requirement."""
    return np.all(hard_excess(requirements, values) <= 0.0, axis=1)
