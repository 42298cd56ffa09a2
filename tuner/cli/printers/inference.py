"""Printer of an inference."""

from typing import TYPE_CHECKING

from tuner.cli.tables import TerminalTable, say_files
from tuner.cli.terminal import Console, unit_text
from tuner.documents.inference_document import InferenceDocument
from tuner.text.numbers import significant

if TYPE_CHECKING:
    from tuner.api.results import InferenceResults


def print_inference(results: "InferenceResults", console: Console) -> None:
    """Print what an inference found."""
    document = results.document
    print_tables(document, console)
    console.print(f"{document.flights:,} flights in {document.wall_seconds:.1f} s.")
    say_files(console, Figure=results.home / "figures" / "inference.png", Study=results.home / "inferred.toml")


def print_tables(document: InferenceDocument, console: Console) -> None:
    """Print cells, unknowns and what they say."""
    console.print(cells_table(document))
    console.print(unknowns_table(document))
    console.bullets(document.words)


VERDICTS = (("yes", "inside"), ("near by", "consistent"), ("elsewhere", "reproducible"), ("never", "published"))
"""What the table says of a cell: the first whose key holds."""


def cells_table(document: InferenceDocument) -> TerminalTable:
    """Return published beside ours."""
    held_out = document.settings.held_out
    table = TerminalTable(f"Published cells and {held_out} held-out flights at the inferred setting")
    table.columns_of("cell", "published", "median", "95 % of ours", "inside", left=("cell",), wrap=("cell",))
    for row in document.cells:
        ours = row.ours
        span = f"{significant(ours.low95, 3)}–{significant(ours.high95, 3)}"
        inside = next(word for word, key in VERDICTS if getattr(row, key))
        name = f"{row.contender} {row.metric} {row.unit}"
        table.add_row(name, significant(row.published), significant(ours.median, 3), span, inside)
    return table


def unknowns_table(document: InferenceDocument) -> TerminalTable:
    """Return the unknowns with their ranges."""
    table = TerminalTable("Unknowns")
    near = f"within {100 * document.settings.near:g} %"
    table.columns_of("", "inferred", near, "one draw leaves", "told", left=("",), wrap=("",))
    for row in document.unknowns:
        spans = [
            f"{significant(getattr(row, low), 2)}–{significant(getattr(row, high), 2)}"
            for low, high in (("near_low", "near_high"), ("low68", "high68"))
        ]
        verdict = {"told": "yes", "loosely": "partly", "not": "no"}[row.verdict]
        table.add_row(f"{row.name}{unit_text(row.unit, ' {}')}", significant(row.inferred, 2), *spans, verdict)
    return table
