"""Costs of a control step on processors, which extensions count."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tuner.extension import objects


@dataclass(frozen=True)
class StepCosts:
    """Costs of a control step on one processor.

    Attributes:
        rows: Function of position law and attitude law that returns rows of the block "cost" of gains.json.
        text: Function of laws and control period [s] that returns a sentence part, None for laws without a count.
        count: Function of the same that returns the fields of a comparison's `ProcessorCount`, None without a count.
    """

    rows: Callable[[str, str], Sequence[dict[str, Any]]]
    text: Callable[[str, str, float], str | None]
    count: Callable[[str, str, float], Mapping[str, Any] | None]


def cost_rows(position: str, attitude: str) -> list[dict[str, Any]]:
    """Return the block "cost" of gains.json for a pair of laws."""
    return [row for costs in _step_costs() for row in costs.rows(position, attitude)]


def cost_text(position: str, attitude: str, control_period: float) -> str:
    """Return the costs of two laws as a sentence part, or ""."""
    return "; ".join(filter(None, (costs.text(position, attitude, control_period) for costs in _step_costs())))


def first_count(position: str, attitude: str, control_period: float) -> Mapping[str, Any] | None:
    """Return the count of two laws on the first processor, or None."""
    counts = (costs.count(position, attitude, control_period) for costs in _step_costs())
    return next((count for count in counts if count is not None), None)


def _step_costs() -> list[StepCosts]:
    return list(objects("costs").values())
