"""`tuner export`: gains for a target, verified after rounding, with what to go back to."""

import json
from pathlib import Path
from typing import Any

import typer
from rich.box import SIMPLE
from rich.table import Table

from tuner.cli.flights_bar import FlightsBar
from tuner.cli.terminal import Console
from tuner.cli.wide import wide_console
from tuner.export.registry import exporter as find_exporter
from tuner.export.run import Export, export_gains

BROKEN = 1

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
        print_export(made)
    if not made.verification.passed:
        raise typer.Exit(BROKEN)


def print_export(made: Export) -> None:
    """Print files, parameters, margins and flights after rounding, and what the target adds or lacks."""
    console, document = wide_console(), made.document
    laws = f"{document['laws']['position']} / {document['laws']['attitude']}"

    def say(text: str) -> None:
        console.print(text, markup=False, highlight=False, soft_wrap=not console.is_terminal)

    say(f"{document['target_version']}: {laws} for {made.airframe}")
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
        say(f"Broken by what the target holds: {label}")
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
    """Return the range of a parameter; null is no bound."""
    low, high = (None if row[key] is None else f"{row[key]:g}" for key in ("low", "high"))
    if low is None:
        return "any" if high is None else f"to {high}"
    return f"{low} up" if high is None else f"{low} to {high}"


def changes_table(verification: Row) -> Table:
    """Return what the target changes in the digits shown: limits and metrics as tuned and as held."""
    flights, scenario = verification["flights"], verification["scenario"]
    title = f"As tuned, and as the target holds it; metrics over {flights} flights, {scenario}"
    table = Table(title=title, title_justify="left", box=SIMPLE)
    for name in ("", "unit", "limit", "tuned", "held"):
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
    """Return in a sentence what becomes of the limits on margins."""
    rows = verification["margins"]
    if not rows:
        return "No margins: this controller holds no steady hover."
    differing = sum(_shown(row["asked"]) != _shown(row["held"]) for row in rows)
    kept = sum(row["kept_held"] for row in rows)
    changed = f"{differing} of them change in five digits, see above" if differing else "none changes in five digits"
    return f"The target keeps {kept} of {len(rows)} limits on margins at hover; {changed}."


def _shown(value: float | None) -> str:
    return "no bound" if value is None else f"{value:.5g}"
