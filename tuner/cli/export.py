"""`tuner export`: gains for a target, verified after rounding, with what to go back to."""

import json
import sys
from pathlib import Path
from typing import Any

import typer
from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from tuner.cli.flights_bar import FlightsBar
from tuner.export.registry import exporter as find_exporter
from tuner.export.run import Export, export_gains
from tuner.gains_file import read_gains

BROKEN = 1
# Beyond it a bound is that of a number type, not of a parameter; a pipe has no width, and 80 columns would cut names.
LARGEST, PIPE_WIDTH = 1e30, 160

Row = dict[str, Any]


def export_command(
    gains: Path, to: str, out: Path | None, firmware: str | None, options: list[str], previous: Path | None,
    flights: int, as_json: bool,
) -> None:  # fmt: skip
    """Export, print what was written and lost; exit code 1 where rounding broke a limit that the gains keep."""
    exporter = find_exporter(to)
    given = [*options, *([f"firmware={firmware}"] if firmware is not None else [])]
    folder = out or gains.resolve().parent / "export" / exporter.name
    with FlightsBar(Console(stderr=as_json)) as bar:
        made = export_gains(gains, exporter, given, previous, folder, flights, bar)
    if as_json:
        print(json.dumps({**made.document, "folder": str(made.folder)}, indent=2, allow_nan=False))
    else:
        print_export(made, read_gains(gains).airframe.title)
    if not made.verification.passed:
        raise typer.Exit(BROKEN)


def print_export(made: Export, airframe: str) -> None:
    """Print files, parameters, margins and flights after rounding, and what the target adds or lacks."""
    console, document = Console(width=None if sys.stdout.isatty() else PIPE_WIDTH), made.document
    laws = f"{document['laws']['position']} / {document['laws']['attitude']}"

    def say(text: str) -> None:
        console.print(text, markup=False, highlight=False, soft_wrap=not console.is_terminal)

    say(f"{document['title']}, {document['target_version']}: {laws} for {airframe}")
    if document["experimental"]:
        say(f"Experimental: {document['experimental']}")
    if document["parameters"]:
        console.print(parameters_table(document["parameters"]))
    verification = document["verification"]
    console.print(changes_table(verification))
    say(said_of_margins(verification))
    for sentence in document["lossy"]:
        say(f"- {sentence}")
    for label in verification["broken"]:
        say(f"Broken by rounding: {label}")
    say(f"{made.folder}: {', '.join([*document['files'], 'rollback/', 'export.json', 'gains.json'])}")


def parameters_table(rows: list[Row]) -> Table:
    """Return the parameters as the target holds them."""
    table = Table(title="Parameters", title_justify="left", box=SIMPLE)
    for name in ("name", "value", "default", "allowed", "unit"):
        left = name in ("name", "unit")
        table.add_column(name, justify="left" if left else "right", no_wrap=name != "unit", overflow="fold")
    for row in rows:
        usual = "" if row["usual"] is None else f"{row['usual']:g}"
        table.add_row(
            row["name"], f"{row['held']:.6g}", usual, _allowed(row), "" if row["unit"] == "1" else row["unit"]
        )
    return table


def _allowed(row: Row) -> str:
    """Return the range of a parameter; a bound that is the end of its type is none."""
    low, high = (None if row[key] is None or abs(row[key]) > LARGEST else f"{row[key]:g}" for key in ("low", "high"))
    if low is None:
        return "any" if high is None else f"to {high}"
    return f"{low} up" if high is None else f"{low} to {high}"


def changes_table(verification: Row) -> Table:
    """Return what rounding changes in the digits shown: limits and metrics before and after."""
    table = Table(
        title=f"Before and after rounding, {verification['flights']} flights", title_justify="left", box=SIMPLE
    )
    for name in ("", "unit", "limit", "asked", "held"):
        table.add_column(name, justify="left" if name in ("", "unit") else "right", no_wrap=True)
    for row in changed_margins(verification):
        sign = ">=" if row["sense"] == "least" else "<="
        table.add_row(row["label"], row["unit"], f"{sign} {row['limit']:g}", _shown(row["asked"]), _shown(row["held"]))
    for row in verification["metrics"]:
        table.add_row(f"mean({row['metric']})", row["unit"], "", _shown(row["asked"]), _shown(row["held"]))
    return table


def changed_margins(verification: Row) -> list[Row]:
    """Return the margins that differ in the digits shown, or are not kept."""
    return [
        row
        for row in verification["margins"]
        if _shown(row["asked"]) != _shown(row["held"]) or not (row["kept_asked"] and row["kept_held"])
    ]


def said_of_margins(verification: Row) -> str:
    """Return in a sentence what rounding does to the margins that the table leaves out."""
    rows = verification["margins"]
    same = len(rows) - len(changed_margins(verification))
    if not rows:
        return "No margins: this controller holds no steady hover."
    return f"{same} of {len(rows)} limits on margins at hover are kept, the same to five digits before and after."


def _shown(value: float | None) -> str:
    return "no bound" if value is None else f"{value:.5g}"
