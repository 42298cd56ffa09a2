"""Printer of a confirmation: rank correlation and gap of every metric, then every finalist."""

from typing import TYPE_CHECKING

from tuner.cli.tables import TerminalTable, say_files
from tuner.cli.terminal import Console
from tuner.documents.confirmation import ConfirmationDocument
from tuner.report.confirmation_page import POINT_HEADS, QUANTITY_HEADS, point_cells, quantity_cells, verdicts
from tuner.text.units import after_number

if TYPE_CHECKING:
    from tuner.api.confirming import Confirmation


def print_confirmation(made: "Confirmation", console: Console) -> None:
    """Print what was flown, tables of metrics and finalists, and where the page is."""
    document = made.document
    for sentence in verdicts(document):
        console.print(sentence)
    console.print(quantities_table(document))
    for i in range(len(document.quantities)):
        console.print(points_table(document, i))
    for note in document.notes:
        console.print(note)
    if made.folder is not None:
        say_files(console, Page=made.folder / "confirm.md", Document=made.folder / "confirm.json")


def quantities_table(document: ConfirmationDocument) -> TerminalTable:
    """Return a row for each metric."""
    table = TerminalTable(f"{document.firmware} and the model", keys=1)
    table.columns_of(*QUANTITY_HEADS, left=QUANTITY_HEADS[:1])
    for each in document.quantities:
        table.add_row(*quantity_cells(each))
    return table


def points_table(document: ConfirmationDocument, i: int) -> TerminalTable:
    """Return a row for each finalist with its values of one metric."""
    quantity = document.quantities[i]
    table = TerminalTable(f"{quantity.label}{after_number(quantity.unit)}", keys=1)
    table.columns_of(*POINT_HEADS, left=POINT_HEADS[:1])
    for point in document.points:
        table.add_row(*point_cells(point, i))
    return table
