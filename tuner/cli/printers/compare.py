"""Printer of a comparison."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rich.text import Text

from objectives.risk.differences import BETTER, WORSE
from tuner.cli.printers.tuning import print_ending, with_count
from tuner.cli.tables import TerminalTable, say_files
from tuner.cli.terminal import Console, bound_text, difference, estimate, unit_text
from tuner.documents.comparison_document import ComparisonDocument, DifferenceRow, QuantityRow

if TYPE_CHECKING:
    from tuner.api.results import ComparisonResults


def print_compared(results: "ComparisonResults", console: Console) -> None:
    """Print a comparison, and where it was written."""
    print_comparison(results.document, console)
    if results.folder is not None:
        say_files(console, Report=results.folder / "report.html", Figures=results.folder / "figures")


def print_comparison(document: ComparisonDocument, console: Console) -> None:
    """Print a table for each quantity, sentences and warnings of a comparison."""
    flights = sum(entry.flights for entry in document.compared_on)
    console.print(f"{document.title}  (seed {document.seed})", style="bold")
    print_ending(document.ending, console)
    console.print(
        f"Each flew the same {flights:,} flights; 95 % intervals; behind each value its difference to {document.first}, "
        "paired flight by flight.",
    )
    for quantity, rows in blocks(document):
        console.print(f"\n{heading(quantity)}", style="bold")
        console.print(block_table(rows, console.width))
    console.print()
    console.bullets(document.words)
    console.warn(document.warnings)
    console.print(f"{document.flights:,} flights in {document.wall_seconds:.1f} s.")


def blocks(document: ComparisonDocument) -> Iterator[tuple[QuantityRow, list[list[str]]]]:
    """Yield each quantity with a row for each contender: name, value, difference to the first, verdict."""
    values = {(row.contender, row.quantity): row for row in document.estimates}
    differences = {(r.second, r.quantity): r for r in document.differences if r.first == document.first}
    for quantity in document.quantities:
        keys = [(contender.name, quantity.label) for contender in document.contenders]
        yield (
            quantity,
            [
                [key[0], with_count(estimate(values[key]), values[key].count), *against(differences.get(key))]
                for key in keys
            ],
        )


def heading(quantity: QuantityRow) -> str:
    """Return label, unit and limit of a quantity."""
    limit = "" if quantity.limit is None else f", {bound_text(quantity)}"
    return f"{quantity.label}{unit_text(quantity.unit, ' [{}]')}{limit}"


def against(row: DifferenceRow | None) -> tuple[str, str]:
    """Return the paired difference to the first, and its interval's verdict."""
    if row is None:
        return "", ""
    return difference(row.estimate), verdict(row)


def verdict(row: DifferenceRow) -> str:
    """Return in a word what a difference says of the second."""
    if row.low == row.high == 0.0:
        return "same"
    return {None: row.verdict, row.second: BETTER, row.first: WORSE}[row.lower]


def block_table(rows: list[list[str]], width: int) -> TerminalTable:
    """Return the rows as a table; a value stands next to its interval where the terminal is wide enough, else above it."""
    wide = [[cell.replace("\n", " ") for cell in row] for row in rows]
    fits = sum(max(map(len, column)) + 2 for column in zip(*wide, strict=True)) + 2 <= width
    table = TerminalTable(box=None, show_header=False)
    table.add_column(style="bold")
    for name in ("value", "difference"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("verdict")
    for row in wide if fits else rows:
        table.add_row(*map(Text, row))
    return table
