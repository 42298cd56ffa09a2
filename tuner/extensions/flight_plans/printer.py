"""Printer of an experiment to fly."""

from typing import TYPE_CHECKING

from tuner.cli.tables import TerminalTable
from tuner.cli.terminal import Console
from tuner.extensions.flight_plans.words import excitation_table, number_table, peak_table

if TYPE_CHECKING:
    from tuner.extensions.flight_plans.api import FlightPlan


def print_flight_plan(plan: "FlightPlan", console: Console) -> None:
    """Print the excitations, the intervals before and after, limits and the verdict."""
    document = plan.document
    tables = (excitation_table(document), number_table(document.numbers), peak_table(document))
    for part in (*map(TerminalTable.of, tables), *document.notes, document.verdict):
        console.print(part)
    if plan.folder is not None:
        console.print(f"Written: {', '.join(str(plan.folder / name) for name in document.files)}.")
        console.print(f"Try it on the simulated log: {plan.trial}")
