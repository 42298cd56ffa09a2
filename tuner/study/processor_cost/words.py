"""The cost of a control step in one line of a report, and as rows of gains.json."""

from typing import Any

from tuner.study.processor_cost.cost import Cost
from tuner.study.processor_cost.table import tabled


def told(position: str, attitude: str, control_period: float) -> str | None:
    """Return the cost of a pair of laws as a sentence part, or None where the table has it not."""
    cost = tabled(position, attitude)
    if cost is None:
        return None
    rate = 1e-6 * cost.per_second(control_period)
    return (
        f"{cost.instructions_step:.0f} instructions on a {cost.target}, {rate:.3g} million a second; {cost.text_bytes} bytes of "
        f"code, {cost.state_bytes} of state, {cost.stack_bytes} of stack"
    )


def gains_rows(cost: Cost | None) -> list[dict[str, Any]]:
    """Return the block "cost" of gains.json: instructions of a control step, bytes of code and constants."""
    if cost is None:
        return []
    return [
        {
            "target": cost.target,
            "tool": cost.tool,
            "instructions": {"value": cost.instructions_step, "unit": "1"},
            "bytes": {"value": cost.text_bytes, "unit": "By"},
        }
    ]
