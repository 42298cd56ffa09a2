"""Requirements on a controller that are known without flying it: bounds that theory gives, stability margins.

An analysis turns gains into numbers, a requirement puts a limit on one of them. What breaks a hard one is not worth a
flight; a soft one is flown and counts as a broken constraint. `Problem` asks before it flies.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from objectives.scales import Scale, in_file, units_of

Array = NDArray[np.float64]

LARGEST_VIOLATION = 1e6
"""Largest count of a violation, in limits: an infinite value must not hide the other violations of a candidate."""


@dataclass(frozen=True)
class Requirement:
    """One number for each candidate, with a limit.

    label: short name, unique in a study. quantity: what the number is, one line for reports. unit: of value and limit, as a study
    file gives it. limit: finite. sense: "most", the value must not exceed the limit, or "least", not fall below it. hard: whether
    a candidate that breaks it is left unflown. scale: from the SI unit of files to `unit`, None where files hold `unit`.
    """

    label: str
    quantity: str
    unit: str
    limit: float
    sense: str
    hard: bool = True
    scale: Scale | None = None

    def __post_init__(self) -> None:
        assert self.sense in ("most", "least") and isfinite(self.limit), "a requirement comes from a checked study"

    def units(self) -> dict[str, str]:
        """Return the unit of value and limit in files, and that in which they are shown where it is another."""
        return units_of(self.unit, self.scale)

    def in_file(self, value: Any) -> Any:
        """Return a value in the unit of files."""
        return in_file(value, self.scale)

    def excess(self, values: Array) -> Array:
        """Return by how much values (n,) are beyond the limit, relative to |limit|, or to 1 where it is 0; below 0 where kept."""
        beyond = values - self.limit if self.sense == "most" else self.limit - values
        return np.clip(beyond / (abs(self.limit) or 1.0), -LARGEST_VIOLATION, LARGEST_VIOLATION)

    def violations(self, values: Array) -> Array:
        """Return by how much values (n,) break the limit, as `excess`, 0 where kept."""
        return np.maximum(self.excess(values), 0.0)

    def kept(self, values: Array) -> NDArray[np.bool_]:
        """Return where values (n,) keep the limit."""
        return self.violations(values) <= 0.0


@dataclass(frozen=True)
class Screen:
    """Requirements that one analysis answers together.

    analyse(gains rows (n, gains)) -> values (n, requirements), never NaN, infinite only where its own documentation says so.
    """

    requirements: tuple[Requirement, ...]
    analyse: Callable[[Array], Array]


def requirements_of(screens: tuple[Screen, ...]) -> tuple[Requirement, ...]:
    """Return the requirements of all screens, in the order of the columns of `known_values`."""
    return tuple(requirement for screen in screens for requirement in screen.requirements)


def known_values(screens: tuple[Screen, ...], gains: Array) -> Array:
    """Return the values (n, requirements) of all screens for gains rows (n, gains)."""
    parts = [np.empty((len(gains), 0))]
    for screen in screens:
        values = screen.analyse(gains)
        expected = (len(gains), len(screen.requirements))
        assert values.shape == expected, f"an analysis returned {values.shape} for {expected}"
        assert not np.isnan(values).any(), "an analysis returned NaN"
        parts.append(values)
    return np.concatenate(parts, axis=1)


def known_violations(requirements: tuple[Requirement, ...], values: Array) -> Array:
    """Return the violations (n, requirements) of values (n, requirements)."""
    broken = np.zeros_like(values)
    for i, requirement in enumerate(requirements):
        broken[:, i] = requirement.violations(values[:, i])
    return broken


def hard_excess(requirements: tuple[Requirement, ...], values: Array) -> Array:
    """Return the excess (n, h) over each hard requirement; a candidate is worth a flight where none is above 0."""
    hard = [entry.excess(values[:, i]) for i, entry in enumerate(requirements) if entry.hard]
    return np.stack(hard, axis=1) if hard else np.empty((len(values), 0))


def worth_flying(requirements: tuple[Requirement, ...], values: Array) -> NDArray[np.bool_]:
    """Return the candidates (n,) that keep every hard requirement."""
    hard = [i for i, requirement in enumerate(requirements) if requirement.hard]
    return np.all(known_violations(requirements, values)[:, hard] <= 0.0, axis=1)
