"""Printer of an airframe that is estimated from its parts list."""

from typing import TYPE_CHECKING

from tuner.cli.tables import TerminalTable
from tuner.cli.terminal import FLY_AIRFRAME, Console, unit_text
from tuner.extensions.parts_list.document import EstimateDocument
from tuner.text.numbers import estimate, significant

if TYPE_CHECKING:
    from tuner.extensions.parts_list.api import EstimatedAirframe


def print_estimate(estimated: "EstimatedAirframe", console: Console) -> None:
    """Print the numbers with intervals and sources, and what to do next."""
    document: EstimateDocument = estimated.document
    table = TerminalTable("95 % ranges", keys=1)
    table.columns_of("", "value", "95 % range", "unit", left=("", "unit"))
    for row in document.numbers:
        value, interval = estimate(row.value, row.low, row.high)
        table.add_row(row.name, value, interval, unit_text(row.unit))
    console.print(table)
    console.print(
        f"Thrust to weight {significant(document.thrust_to_weight, 2)}, of the middle of the ranges. Sources stand in the file."
    )
    console.print(FLY_AIRFRAME.format(document.file))
    console.print(document.verdict)
