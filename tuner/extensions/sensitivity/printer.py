"""Printer of a sensitivity analysis."""

from typing import TYPE_CHECKING

from plant.ties import increasing_order
from tuner.cli.tables import TerminalTable
from tuner.cli.terminal import Console
from tuner.extensions.sensitivity.document import VarianceRow
from tuner.extensions.sensitivity.indices import RANK
from tuner.extensions.sensitivity.tables import FAILURE, outputs

if TYPE_CHECKING:
    from tuner.extensions.sensitivity.api import Sensitivity


def print_sensitivity(sensitivity: "Sensitivity", console: Console) -> None:
    """Print both tables and the notes."""
    for output, name in enumerate(outputs(sensitivity.study)):
        if sensitivity.analysis.indices[RANK].total.value[output].any():
            console.print(index_table_of(sensitivity, output, name))
    document = sensitivity.document
    console.print(variance_table_of(document.variance))
    for note in document.notes:
        console.print(f"Note: {note}", style="yellow")
    console.print(f"{document.flights:,} flights in {document.seconds:.1f} s.")
    if sensitivity.folder is not None:
        print(f"Tables and chart: {sensitivity.folder}")


def index_table_of(sensitivity: "Sensitivity", output: int, name: str) -> TerminalTable:
    """Return the indices of one output, the variable that decides most first."""
    what = name if name == FAILURE else f"rank of {name}"
    table = TerminalTable(f"{what}: shares of its variance, 95 % intervals", keys=1)
    table.columns_of("variable", "alone (first order)", "with all others (total)", left=("variable",))
    orders = sensitivity.analysis.indices[RANK]
    for i in increasing_order(-orders.total.value[output]):
        cells = [
            f"{spans.value[output, i]:.2f} [{spans.low[output, i]:.2f}, {spans.high[output, i]:.2f}]"
            for spans in orders
        ]
        table.add_row(sensitivity.study.space.variables[i].name, *cells)
    return table


def variance_table_of(rows: list[VarianceRow]) -> TerminalTable:
    """Return the shares of gains and air in each metric's variance."""
    count = rows[0].candidates
    title = f"Variance of a single flight's metric, over {count:,} samples that completed every flight [%]"
    table = TerminalTable(title, keys=1)
    parts = ("gains", "scenario", "gains x scenario", "turbulence: the last two")
    table.columns_of("metric of", *parts, left=("metric of",), wrap=parts)
    for row in rows:
        parts = row.components_percent
        cells = ["-"] * 4 if parts is None else [f"{x:.1f}" for x in (*vars(parts).values(), row.turbulence_percent)]
        table.add_row(row.objective, *cells)
    return table
