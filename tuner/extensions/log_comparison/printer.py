"""Printer of a comparison of two logs."""

from typing import TYPE_CHECKING

from tuner.cli.tables import TerminalTable
from tuner.cli.terminal import Console, unit_text
from tuner.extensions.identification.printer import log_text
from tuner.text.numbers import estimate, significant

if TYPE_CHECKING:
    from tuner.extensions.log_comparison.api import LogComparison


def print_log_comparison(comparison: "LogComparison", console: Console) -> None:
    """Print the measures of both logs, ratios, predictions and the verdict."""
    document = comparison.document
    for row in (document.before, document.after):
        console.print(log_text(row))
    table = TerminalTable("After over before, 95 % intervals", keys=1)
    table.columns_of("", "before", "after", "ratio", "", "predicted", "unit", left=("", "unit"))
    for row in document.measures:
        ratio, interval = estimate(row.ratio.value, row.ratio.low, row.ratio.high)
        limit = "" if row.predicted is None else f"<= {significant(row.predicted, 3)}"
        values = (significant(row.before.value, 3), significant(row.after.value, 3))
        table.add_row(row.name, *values, f"{ratio} {interval}", row.change, limit, unit_text(row.unit))
    console.print(table)
    console.print(document.verdict)
