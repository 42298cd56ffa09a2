"""The tables that end a tuning run: objectives, limits and gains, default against tuned, in plain words."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.text import Text

from objectives.margins.quantities import QUANTITIES
from tuner.cli.tables import TerminalTable
from tuner.cli.terminal import Console, bound_text, estimate, unit_text
from tuner.documents.parts import Estimate, on_page
from tuner.documents.summary import ComparedRow, RequiredRow, UnseenLosses
from tuner.documents.tuning import SHOWN
from tuner.documents.verdicts import SATISFIED
from tuner.report.labels import named
from tuner.report.verdict_text import beside_limit, is_violated
from tuner.text.numbers import significant
from tuner.text.sentences import listing
from tuner.text.units import in_degrees

if TYPE_CHECKING:
    from tuner.documents.tuning import TuningFolder

VIOLATED = "!"
"""Sign behind a value that violates its limit."""
ALIGNED_WIDTH = 72
"""Columns of the terminal from which on the columns of all tables are aligned."""


def print_end_tables(results: "TuningFolder", console: Console) -> None:
    """Print objectives, limits and gains; limits that both satisfy take a line."""
    shown, clear = split_limits(results.document.table)
    tables = [objectives_table(results), *([limits_table(results, shown)] if shown else []), gains_table(results)]
    if console.width >= ALIGNED_WIDTH:
        align(tables)
    console.print(tables[0])
    if results.document.unseen is not None:
        console.print(unseen_text(results, results.document.unseen))
    if shown or clear:
        console.print()
    if shown:
        console.print(tables[1])
    if clear:
        console.print(clear_text(results, clear))
    console.print()
    console.print(tables[-1])
    console.print()


def split_limits(
    table: Sequence[ComparedRow | RequiredRow],
) -> tuple[list[ComparedRow | RequiredRow], list[ComparedRow | RequiredRow]]:
    """Return the limits to show by row, and those that both satisfy."""
    limits = [row for row in table if row.limit is not None]
    clear = [row for row in limits if row.verdict == SATISFIED and not is_violated(row, row.default.value)]
    return [row for row in limits if row not in clear], clear


def objectives_table(results: "TuningFolder") -> TerminalTable:
    """Return default, tuned and change of each objective."""
    summary = results.document
    table = head(f"{summary.held_out:,} confirmation {results.sample_noun}", summary.shown_as, "change, 95 % interval")
    for row in results.objectives:
        change = estimate(row.difference, signed=True).replace("\n", " ")
        values = map(middle, (row.default, row.tuned))
        table.add_row(labeled(named(results, row, short=True), row.unit), *values, change)
    return table


def unseen_text(results: "TuningFolder", unseen: UnseenLosses) -> str:
    """Return the values that losses would raise objectives to."""
    raised = []
    for row in results.document.compared:
        for entry in unseen.objectives:
            if entry.label == row.label and row.kind == "objective":
                unit, factor = in_degrees(entry.unit)
                value = f"{significant(factor * entry.raised, 3)} {unit_text(unit)}".rstrip()
                raised.append(f"{named(results, row, short=True)} to {value}")
    return f"Unseen losses ({unseen.count.words}) could raise {listing(raised)}."


def limits_table(results: "TuningFolder", rows: Sequence[ComparedRow | RequiredRow]) -> TerminalTable:
    """Return default, tuned, limit, and the worst steady state of tuned margins."""
    has_states = any(row.kind == "requirement" and row.tuned_state for row in rows)
    has_loops = any(row.kind == "requirement" and row.label in QUANTITIES for row in rows)
    title = "Limits (margins: worst loop)" if has_loops else "Limits"
    table = head(title, results.document.shown_as, "limit", *(["worst in"] if has_states else []))
    shown = [on_page(row, *SHOWN) for row in rows]
    columns = (marked([(row, row.default) for row in shown]), marked([(row, row.tuned) for row in shown]))
    for row, *values in zip(shown, *columns, strict=True):
        name = labeled(named(results, row, short=True), row.unit) + (
            f" (automatic: {row.automatic})" if row.automatic else ""
        )
        state = (row.tuned_state or "") if row.kind == "requirement" else ""
        table.add_row(name, *values, bound_text(row), *([state] if has_states else []))
    return table


def clear_text(results: "TuningFolder", rows: Sequence[ComparedRow | RequiredRow]) -> str:
    """Return the limits that both satisfy with their values, automatic ones last."""
    names: dict[str, list[str]] = {}
    for row in sorted(rows, key=lambda row: bool(row.automatic)):
        names.setdefault(row.automatic, []).append(clear_limit_text(results, row))
    parts = [f"{f'automatic ({key}): ' if key else ''}{'; '.join(of_key)}" for key, of_key in names.items()]
    return f"Satisfied by both: {'; '.join(parts)}."


def clear_limit_text(results: "TuningFolder", row: ComparedRow | RequiredRow) -> str:
    """Return "level overshoot 7.3 % (max 15)", or the counts behind a share."""
    _, evidence = row.evidence
    name = named(results, row, short=True)
    if evidence:
        return f"{name} ({evidence})"
    row = on_page(row, *SHOWN)
    return f"{name} {limited(row, row.tuned)} {unit_text(row.unit)}".rstrip() + f" ({bound_text(row)})"


def gains_table(results: "TuningFolder") -> TerminalTable:
    """Return the searched gains with their ranges."""
    table = head("Gains", results.document.shown_as, "range")
    for row in results.variables:
        values = (f"{value:.4g}" for value in (row.default, row.tuned))
        table.add_row(labeled(row.name, row.unit), *values, f"{row.low:g} to {row.high:g}")
    return table


def head(title: str, shown: str, *last: str) -> TerminalTable:
    """Return a table with columns for names, default, tuned, and others."""
    table = TerminalTable(box=None)
    return table.columns_of(title, "default", shown, *last, left=(title, *last), wrap=(title, *last[1:]))


def align(tables: Sequence[TerminalTable]) -> None:
    """Give the first three columns of tables common widths."""
    for i in range(3):
        columns = [table.columns[i] for table in tables]
        width = max(len(line) for column in columns for line in [str(column.header), *map(str, column.cells)])
        for column in columns:
            column.header = str(column.header).ljust(width) if i == 0 else str(column.header).rjust(width)


def labeled(name: str, unit: str) -> str:
    """Return a name with its unit in brackets."""
    return f"{name}{unit_text(unit, ' [{}]')}"


def middle(entry: Estimate) -> str:
    """Return a value with the digits that its interval supports."""
    return "inf" if entry.value is None else estimate(entry).split("\n")[0]


def limited(row: ComparedRow | RequiredRow, entry: Estimate) -> str:
    """Return a limited value, rounded without crossing its limit."""
    if entry.value is None or entry.low is not None:
        return middle(entry)
    return beside_limit(entry.value, row)


def marked(cells: Sequence[tuple[ComparedRow | RequiredRow, Estimate]]) -> list[Text]:
    """Return a column of values, with a sign behind violations."""
    violated = [is_violated(row, entry.value) for row, entry in cells]
    blank = "  " if any(violated) else ""
    return [
        Text(f"{limited(row, entry)} {VIOLATED}", "bold red") if is_over else Text(limited(row, entry) + blank)
        for (row, entry), is_over in zip(cells, violated, strict=True)
    ]
