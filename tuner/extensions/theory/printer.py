"""Printer of guarantees of theory."""

from typing import TYPE_CHECKING

from tuner.cli.tables import TerminalTable
from tuner.cli.terminal import Console

if TYPE_CHECKING:
    from tuner.extensions.theory.api import Theory


def print_theory(theory: "Theory", console: Console) -> None:
    """Print the rows as a table, or that no theorem applies."""
    rows, document = theory.document.theorems, theory.document
    if not rows:
        console.print("No theorem speaks of these laws; `tuner list theorems` shows which it speaks of.")
        return
    scenarios = ", ".join(document.scenarios)
    origin = f"measured in {scenarios}: {100.0 * document.level:g} % quantile over {theory.control_period:g} s"
    table = TerminalTable(f"Guarantees by theory; disturbance rate {origin}", keys=2)
    table.columns_of("axis", "theorem", "value", "disturbance rate", "holds", left=("axis", "theorem", "holds"))
    words = {True: "yes", False: "no", None: "a bound"}
    for row in rows:
        value = "unbounded" if row.value is None else f"{row.value:.4g} {row.unit}"
        rate = f"{row.disturbance_rate:.4g} {row.rate_unit}"
        table.add_row(row.axis, row.theorem, value, rate, words[row.holds])
    console.print(table)
    for row in {row.theorem: row for row in rows}.values():
        console.print(f"{row.theorem}: {row.quantity}. Assumes {row.assumes}.")
