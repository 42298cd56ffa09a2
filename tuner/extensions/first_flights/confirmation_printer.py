"""Printer of a confirmation: rank correlation and gap of every metric, then every finalist."""

from typing import TYPE_CHECKING

from tuner.cli.tables import TerminalTable, say_files
from tuner.cli.terminal import Console
from tuner.extensions.first_flights.confirmation_page import point_table, quantity_table, verdicts

if TYPE_CHECKING:
    from tuner.extensions.first_flights.confirmation_api import Confirmation


def print_confirmation(made: "Confirmation", console: Console) -> None:
    """Print verdicts, tables of metrics and finalists, and the page's place."""
    document = made.document
    tables = [quantity_table(document), *[point_table(document, i) for i in range(len(document.quantities))]]
    for part in (*verdicts(document), *map(TerminalTable.of, tables), *document.notes):
        console.print(part)
    if made.folder is not None:
        say_files(console, Page=made.folder / "confirm.md", Document=made.folder / "confirm.json")
