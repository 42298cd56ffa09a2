"""Printer of a tuning run."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from tuner.cli.printers.margins import print_states
from tuner.cli.tables import TerminalTable, say_files
from tuner.cli.terminal import Console, estimate, limit_text, unit_text
from tuner.documents.parts import ShareCount, in_shown_units
from tuner.documents.summary import ComparedRow, RequiredRow, Summary, gains_name
from tuner.report.words import loss_words, uncertainty_words

if TYPE_CHECKING:
    from tuner.api.results import TuningResults
    from tuner.experiments.again.verify import Verdict


def print_verdict(verdict: "Verdict", console: Console) -> None:
    """Print whether a run is what this machine computes."""
    console.print(verdict.words, soft_wrap=True)


def print_tuning(results: "TuningResults", console: Console) -> None:
    """Print what a tuning run or a second judgement found."""
    summary = results.document
    print_ending(summary.ending, console)
    console.print(gains_table(summary))
    console.print(comparison_table(summary))
    print_states(console, [row for row in summary.table if isinstance(row, RequiredRow)])
    if results.feasible:
        console.print(f"Recommended: {summary.tuned}: {summary.pick.why}.")
    console.warn(summary.warnings)
    for text in (*loss_words(summary), *summary.remarks, *map(uncertainty_words, summary.uncertainty)):
        console.print(text)
    if summary.search:
        console.print(summary.search)
    screened = summary.screened
    if any(row.kind == "requirement" for row in summary.table):
        console.print(
            f"Skipped without simulation (hard requirement violated): {screened.candidates:,} candidates; "
            f"{screened.flights:,} flights saved.",
        )
    raced = summary.raced
    if raced.candidates:
        console.print(
            f"Races that ended early: {raced.candidates:,} candidates; {raced.flights:,} flights saved.",
        )
    settled = summary.settled
    if settled.candidates:
        console.print(
            f"Held-out flights ended early, for their place was settled: {settled.candidates:,} finalists; {settled.flights:,} "
            "flights saved.",
        )
    made, flights = results.flights_made, summary.flights
    now = "" if made in (None, flights) else f" ({made:,} flights flown now, the others were there)"
    took = "" if summary.wall_seconds is None else f" in {summary.wall_seconds:.1f} s"
    console.print(f"{flights:,} flights{now}{took}.")
    files = {"Gains" if results.feasible else "Gains (infeasible)": results.home / gains_name(results.feasible)}
    say_files(console, Report=results.home / "report.html", **files)


def print_ending(ending: Sequence[str], console: Console) -> None:
    """Print what a run or contest that found nothing feasible has to say before all else; nothing for any other."""
    for i, text in enumerate(ending):
        console.print(text, style="bold red" if i == 0 else "red")


def comparison_table(summary: Summary) -> TerminalTable:
    """Return the Default / Tuned table of a summary."""
    shown = summary.shown_as
    table = TerminalTable(
        f"Default / {shown.capitalize()} on {summary.held_out} confirmation scenarios, 95 % intervals",
    )
    table.columns_of("", "default", shown, f"{shown} - default", left=("",), wrap=("",))
    for row in map(in_shown_units, summary.table):
        limit = "" if row.limit is None else f"{limit_text(row)} "
        limit = f"automatic, {limit}" if getattr(row, "automatic", "") else limit
        parts = [estimate(getattr(row, key)) for key in ("default", "tuned", "difference")]
        parts[2] = f"{row.verdict}: {parts[2]}"
        if isinstance(row, ComparedRow):
            parts = [*map(with_count, parts, (row.default_count, row.tuned_count, None))]
        label = row.label.replace("@", "\n@")
        table.add_row(f"{label}\n{limit}{unit_text(row.unit)}".rstrip(), *parts)
    return table


def with_count(text: str, count: ShareCount | None) -> str:
    """Return a cell with the count behind its share on a line of its own, "0 of 256: at most 1.2 %"."""
    return text if count is None else f"{text}\n{count.words}"


def gains_table(summary: Summary) -> TerminalTable:
    """Return the searched gains, default and tuned."""
    table = TerminalTable("Gains")
    table.columns_of("gain", "unit", "default", summary.shown_as, "range", left=("gain", "unit"), wrap=("unit",))
    for entry in summary.variables:
        table.add_row(
            entry.name, entry.unit, f"{entry.default:.4g}", f"{entry.tuned:.4g}",
            f"{entry.low:g} to {entry.high:g}",
        )  # fmt: skip
    return table
