"""Listings, for a person."""

from typing import Any

from rich.text import Text

from plant.law_registry import LAWS
from plant.laws.law_text import law_text
from tuner.api.catalogue import about_of, listings, rows_of
from tuner.api.frames import json_text
from tuner.cli.tables import TerminalTable, wide_console

# Columns that --json carries and a terminal has no room for.
WIDE = {
    "airframes": {"frame"},
    "laws": {"title", "source", "scale", "symbol"},
    "studies": {"file", "shipped"},
    "targets": {"experimental", "attitude", "position"},
    "theorems": {"quantity", "rates", "assumes", "source"},
}


# Column whose values stand as lines of their own above the rows that share them.
GROUPED = {"laws": "law"}


def print_listings(as_json: bool) -> None:
    """Print each registry with its number of rows and its meaning."""
    rows = [{"what": name, "rows": len(list(make())), "about": about_of(name)} for name, make in listings().items()]
    if as_json:
        print(json_text(rows))
        return
    table = TerminalTable()
    table.columns_of("what", "rows", "about", left=("what", "about"))
    for row in rows:
        table.add_row(row["what"], str(row["rows"]), row["about"])
    wide_console().print(table)
    print("See one of them with: tuner list laws")


def print_listing(what: str, containing: str | None, as_json: bool) -> None:
    """Print one registry, or its rows that hold a text, case-insensitively."""
    rows = rows_of(what, containing or "")
    if as_json:
        print(json_text(rows))
        return
    if not rows:
        print(f"No {what} with '{containing}'." if containing else f"No {what} here.")
        return
    name = str(rows[0].get("law"))
    if what == "laws" and containing is not None and containing.casefold() == name.casefold():
        _print_equations(name)
    group = GROUPED.get(what)
    columns = [column for column in rows[0] if column not in WIDE.get(what, set()) and column != group]
    table = TerminalTable()
    for column in columns:
        # A colon alone is no place to break a heading.
        table.add_column(Text(column.replace(":", ": ")))
    before: str | None = None
    for row in rows:
        if group and row[group] != before:
            before = str(row[group])
            table.add_row(Text(before, style="bold"))
        first, *others = [_cell_text(row[column]) for column in columns]
        table.add_row(Text(f"  {first}" if group else first), *map(Text, others))
    wide_console().print(table)


def _print_equations(name: str) -> None:
    """Print title and equations of a law, as its page has them."""
    law = LAWS.find(name)
    text = law_text(law)
    print("\n".join(line for line in (law.title, text.equations, text.use) if line), end="\n\n")


def _cell_text(cell: Any) -> str:
    """Return a value of a row as a person reads it."""
    if isinstance(cell, bool):
        return "yes" if cell else "no"
    if isinstance(cell, float):
        return f"{cell:.4g}"
    return "" if cell is None else str(cell)
