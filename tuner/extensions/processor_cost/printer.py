"""The cost of gains, for a person."""

from typing import TYPE_CHECKING

from tuner.cli.tables import TerminalTable
from tuner.cli.terminal import Console
from tuner.extensions.processor_cost.cost import CONTROL_PERIOD

if TYPE_CHECKING:
    from tuner.extensions.processor_cost.api import Cost, CostRow


def print_costs(cost: "Cost", console: Console) -> None:
    """Print a line a controller, and below how it was counted."""
    rows = cost.document.costs
    first = rows[0]
    title = f"Instructions and bytes on a {first.target} (mean, largest), position law {first.position}"
    table = TerminalTable(title, keys=1)
    speed = f"million/s\nat {1.0 / first.control_period.value:.4g} Hz"
    sizes = [f"{what}\nbyte" for what in ("code", "state", "stack")]
    table.columns_of("attitude law", "attitude\nloops", "whole\ncascade", speed, *sizes, left=("attitude law",))
    for row in rows:
        table.add_row(
            row.attitude,
            f"{row.instructions_attitude:.0f}, {row.most_attitude}",
            f"{row.instructions_step:.0f}, {row.most_step}",
            f"{1e-6 * row.instructions_per_second:.3f}",
            str(row.text_bytes),
            str(row.state_bytes),
            str(row.stack_bytes),
        )
    console.print(table)
    console.print(f"Counted: {cost.document.meaning}.")
    console.print(f"Tools: {first.compiler} ({first.flags}), {first.emulator}; {origin(first)}")


def origin(row: "CostRow") -> str:
    """Return the source of a row."""
    if row.measured:
        return "counted just now."
    return f"from the packaged table, at default gains and {1e3 * CONTROL_PERIOD:g} ms; --measure counts these gains."
