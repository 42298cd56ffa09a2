"""Decision variables of a search on the unit cube, tied to gains."""

from dataclasses import asdict, dataclass
from math import ceil, exp, floor, isfinite, log
from typing import Any

import numpy as np

from plant.errors import InputError

SCALES = ("linear", "log")


@dataclass(frozen=True)
class Variable:
    """One decision variable: every gain address in `addresses` takes its value.

    Attributes:
        low, high: range of the value, in the gain's unit.
        scale: "log" or "linear", how the unit interval maps to it.
        step: values are its multiples inside the range, 0 for all of them.
    """

    name: str
    addresses: tuple[str, ...]
    low: float
    high: float
    scale: str = "linear"
    step: float = 0.0

    def __post_init__(self) -> None:
        given = f"given [{self.low}, {self.high}]"
        if self.scale not in SCALES:
            raise InputError(f"given scale '{self.scale}'; allowed: 'linear', 'log'", key=self.name)
        if not (isfinite(self.low) and isfinite(self.high)):
            raise InputError(f"{given}; both ends of a range must be finite", key=self.name)
        if self.low >= self.high:
            raise InputError(
                f"{given}; the lower end must be below the upper end (fix the gain if you mean one value)",
                key=self.name,
            )
        if self.step and ceil(self.low / self.step) > floor(self.high / self.step):
            raise InputError(f"{given}; no multiple of {self.step:g} lies between: make the range wider", key=self.name)
        if self.scale == "log" and self.low <= 0.0:
            raise InputError(
                f'{given}; a log scale needs a lower end above 0: raise it, or write scale = "linear"', key=self.name
            )

    def value(self, unit: np.ndarray) -> np.ndarray:
        """Map unit-interval coordinates to values."""
        if self.scale == "log":
            value = self.low * np.exp(unit * log(self.high / self.low))
        else:
            value = self.low + unit * (self.high - self.low)
        if not self.step:
            return value
        return self.step * np.clip(np.rint(value / self.step), ceil(self.low / self.step), floor(self.high / self.step))

    def unit(self, value: float) -> float:
        """Map a value to the unit interval; values outside the range land on its ends."""
        inside = min(max(value, self.low), self.high)
        if self.scale == "log":
            return log(inside / self.low) / log(self.high / self.low)
        return (inside - self.low) / (self.high - self.low)

    def content(self) -> dict[str, Any]:
        """Return its fields as data; the step only where there is one, as files hold it."""
        fields = asdict(self)
        return fields if self.step else {name: value for name, value in fields.items() if name != "step"}

    def middle(self) -> float:
        """Return the value at the middle of the unit interval."""
        return self.low * exp(0.5 * log(self.high / self.low)) if self.scale == "log" else 0.5 * (self.low + self.high)


@dataclass(frozen=True)
class DecisionSpace:
    """Decision variables over a row of gains.

    Attributes:
        variables: variables in their order.
        columns: columns of the gains row that take the value of each variable.
        base: the gains row that stands where no variable does (fixed and default gains).
    """

    variables: tuple[Variable, ...]
    columns: tuple[tuple[int, ...], ...]
    base: tuple[float, ...]

    def gains(self, points: np.ndarray) -> np.ndarray:
        """Map points of the unit cube (n, d) to gains rows (n, gains)."""
        rows = np.tile(np.array(self.base), (len(points), 1))
        for i, (variable, columns) in enumerate(zip(self.variables, self.columns, strict=True)):
            rows[:, list(columns)] = variable.value(points[:, i])[:, None]
        return rows

    def point(self, row: np.ndarray) -> np.ndarray:
        """Map a gains row to the nearest point of the unit cube (d,); a variable takes the value of its first gain."""
        return np.array([v.unit(float(row[c[0]])) for v, c in zip(self.variables, self.columns, strict=True)])

    def values(self, points: np.ndarray) -> np.ndarray:
        """Map points of the unit cube (n, d) to values of the variables (n, d)."""
        return np.stack([v.value(points[:, i]) for i, v in enumerate(self.variables)], axis=1)
