"""A plan, for a person."""

from typing import TYPE_CHECKING

from tuner.cli.tables import TerminalTable
from tuner.cli.terminal import Console, digits, unit_text
from tuner.documents.plan import PlanDocument, PlannedObjective
from tuner.extension import added, load

if TYPE_CHECKING:
    from tuner.api.planning import Plan


def print_plan(plan: "Plan", console: Console) -> None:
    """Print the plan of a study."""
    document = plan.document
    printer = show if isinstance(document, PlanDocument) else load(added("printers")[type(document).__name__])
    printer(document, console)
    for text in plan.notes:
        print(text)


def show(document: PlanDocument, console: Console) -> None:
    """Print the plan."""
    pilot = document.pilot
    console.print(document.search)
    console.print(
        f"Pilot: {pilot.candidates} candidates, {pilot.flights:,} flights in {pilot.seconds:.1f} s on "
        f"{document.threads} threads; {pilot.worth_flying_percent:.0f} % of the ranges are worth a flight.",
    )
    console.print(f"Plant: {document.plant_step.words}.")
    console.print(cost_table(document))
    console.print(precision_table(document))
    for entry in (*document.bounds, *document.tails):
        console.print(entry.words)
    console.warn(document.warnings)


def cost_table(document: PlanDocument) -> TerminalTable:
    """Return flights, time, memory and disk."""
    flights, seconds = document.flights, document.seconds
    table = plain_table("A run takes at most")
    estimated = sum(entry.points_at_most * entry.flights for entry in document.tails)
    tails = [("rare losses", f"{estimated:,} flights", f"{seconds.tails_at_most:.0f} s")] if document.tails else []
    rows = (
        ("search", f"{flights.search_at_most:,} flights", f"{seconds.search:.0f} s"),
        (
            f"held-out check of {flights.finalists_at_most} finalists",
            f"{flights.held_out_at_most:,} flights",
            f"{seconds.held_out_at_most:.0f} s",
        ),
        *tails,
        ("responses, figures, report", "", f"{seconds.writing:.0f} s"),
        ("all of it", f"{flights.total_at_most + estimated:,} flights", f"{seconds.total_at_most:.0f} s"),
        ("compilation, once", "", done_or(seconds.compilation)),
        ("memory", f"{1e-6 * document.memory_bytes:,.0f} MB", ""),
        ("results folder", f"{1e-6 * document.disk_bytes_at_most:,.0f} MB", ""),
    )
    for row in rows:
        table.add_row(*row)
    return table


def plain_table(title: str) -> TerminalTable:
    """Return an empty table of names, counts and times."""
    table = TerminalTable(title, show_header=False)
    table.add_column("")
    table.add_column("", justify="right", no_wrap=True)
    table.add_column("")
    return table


def done_or(seconds: float | None) -> str:
    """Return the time of the compilation."""
    return "done before" if seconds is None else f"{seconds:.0f} s, done now"


def precision_table(document: PlanDocument) -> TerminalTable:
    """Return the expected intervals of the default's objectives, and the scenarios needed.

    They are those that a difference takes.
    """
    title = (
        f"Widths of 95 % intervals, and held-out scenarios that tell {document.difference_percent:g} % of the default"
    )
    table = TerminalTable(title, keys=1)
    table.columns_of("objective", "default", "search", "held out", "needed", left=("objective",))
    for row in document.objectives:
        value = digits(row.default, row.width.held_out or row.default)
        needed = "-" if row.scenarios_needed is None else f"{row.scenarios_needed:,}"
        table.add_row(
            row.label,
            f"{value}{unit_text(row.unit, ' {}')}",
            width(row, "search"),
            width(row, "held_out"),
            f"{needed} / {row.flights.held_out:,}",
        )
    return table


def width(row: PlannedObjective, stream: str) -> str:
    """Return an interval's width with its share of the value."""
    if getattr(row.width, stream) is None:
        return "unknown"
    share = getattr(row.width_percent, stream)
    return digits(getattr(row.width, stream), getattr(row.width, stream)) + (
        "" if share is None else f" ({share:.2g} %)"
    )
