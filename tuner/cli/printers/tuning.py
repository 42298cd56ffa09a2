"""Printer of a tuning run."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from tuner.cli.printers.margins import print_states
from tuner.cli.printers.run_end import labeled, middle, print_end_tables
from tuner.cli.tables import TerminalTable
from tuner.cli.terminal import Console, bound_text, estimate, unit_text
from tuner.documents.parts import ShareCount, in_shown_units, row_in_degrees
from tuner.documents.summary import Summary
from tuner.documents.tuning import DEFAULT
from tuner.documents.verdicts import shown_verdict
from tuner.report.charts.text import place_bar
from tuner.report.labels import named
from tuner.report.named_points import change_text
from tuner.report.verdict_text import verdict_text
from tuner.report.words import loss_words, search_texts, uncertainty_words

if TYPE_CHECKING:
    from tuner.api.results import TuningResults
    from tuner.experiments.again.verify import Verdict

POINTS = "Points of the front, held out"
BAR_LENGTH = 16
"""Length of the bar of a range."""
PLAIN_WIDTH = 72
"""Columns of a terminal from which on there is room for the bar."""


def print_verdict(verdict: "Verdict", console: Console) -> None:
    """Print whether a run is what this machine computes."""
    console.print(verdict.words, soft_wrap=True)


def print_tuning(results: "TuningResults", console: Console) -> None:
    """Print the end of a tuning run or of a second judgement: the verdict first, then tables, reason and warnings."""
    summary = results.document
    print_ending(summary.ending, console)
    console.print(verdict_text(results), style="bold")
    console.print()
    print_end_tables(results, console)
    print_points(results, console)
    if results.feasible and summary.tuned != DEFAULT:
        console.print(f"Why the {results.shown_name}: {summary.pick.why}.")
    console.warn(summary.warnings)
    files = ", ".join(("report.html", summary.gains_file))
    console.print(f"Results in {results.home}: {files} ({flights_text(results)}).", soft_wrap=True)


def print_points(results: "TuningResults", console: Console) -> None:
    """Print the named points of the front, if other than recommended.

    Each value has its change from the default.
    """
    points = results.document.points
    if all(entry.recommended for entry in points):
        return
    labels = [labeled(named(results, row, short=True), row.unit) for row in results.objectives]
    table = TerminalTable(box=None)
    table.columns_of(POINTS, *labels, left=(POINTS,), wrap=(POINTS, *labels))
    for entry in points:
        values = [row_in_degrees(value, "held_out", "difference") for value in entry.objectives]
        cells = [
            f"{middle(value.held_out)}, {change_text(value.held_out, value.difference)}".strip(", ") for value in values
        ]
        table.add_row(f"{entry.name} ({entry.point}{', recommended' if entry.recommended else ''})", *cells)
    console.print(table)
    console.print()


def flights_text(results: "TuningResults") -> str:
    """Return flights and seconds of a run: "4,200 flights in 3.5 s"."""
    made, summary = results.flights_made, results.document
    # Fresh flights of the points at a limit are made besides those that are counted.
    now = "" if made is None or made >= summary.flights else f", {made:,} of them now,"
    took = "" if summary.wall_seconds is None else f" in {summary.wall_seconds:.1f} s"
    return f"{summary.flights:,} {results.sample_noun}{now}{took}"


def finding_texts(summary: Summary) -> list[str]:
    """Return sentences on failed flights, limits, vehicle parameters and search."""
    costs = map(uncertainty_words, summary.uncertainty)
    return [*loss_words(summary), *summary.remarks, *costs, *search_texts(summary)]


def print_tables_of_run(summary: Summary, console: Console) -> None:
    """Print gains, Default / Tuned and margins by steady state."""
    console.print(gains_table(summary, console.width))
    console.print(comparison_table(summary))
    print_states(console, summary.required)


def print_ending(ending: Sequence[str], console: Console) -> None:
    """Print the ending of a run or contest without a feasible point.

    Any other has none.
    """
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
        limit = "" if row.limit is None else f"{bound_text(row)} "
        source = f" (automatic: {row.automatic})" if row.automatic else ""
        parts = [estimate(getattr(row, key)) for key in ("default", "tuned", "difference")]
        parts[2] = f"{shown_verdict(row.verdict)}: {parts[2]}"
        parts = [f"{part}\n{words}".rstrip() for part, words in zip(parts, (*row.evidence, ""), strict=True)]
        label = row.label.replace("@", "\n@")
        table.add_row(f"{label}\n{limit}{unit_text(row.unit)}{source}".rstrip(), *parts)
    return table


def with_count(text: str, count: ShareCount | None) -> str:
    """Return a cell with a second line for its share's count: "0 of 256: at most 1.4 %"."""
    return text if count is None else f"{text}\n{count.words}"


def gains_table(summary: Summary, room: int = PLAIN_WIDTH) -> TerminalTable:
    """Return the searched gains, default (D) and tuned (@), in their ranges.

    room: columns of the terminal.
    """
    table = TerminalTable(f"Gains (D default, @ {summary.shown_as})")
    table.columns_of(
        "gain", "unit", "default", summary.shown_as, "range", left=("gain", "unit", "range"), wrap=("unit",)
    )
    # The bar is longer than the ends of the range where there is room, else it goes.
    wide = room >= PLAIN_WIDTH
    for row in summary.variables:
        bar = place_bar(row.place(row.tuned), row.place(row.default), BAR_LENGTH if wide else BAR_LENGTH // 2)
        ends = f"{row.low:g} {bar} {row.high:g}" if wide else bar
        table.add_row(row.name, unit_text(row.unit), f"{row.default:.4g}", f"{row.tuned:.4g}", ends)
    return table
