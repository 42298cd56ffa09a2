"""Printers of a contest, and of the plan of one."""

from typing import TYPE_CHECKING

from tuner.cli.printers.planning import done_or, plain_table, show
from tuner.cli.printers.tuning import print_ending, with_count
from tuner.cli.tables import TerminalTable, say_files
from tuner.cli.terminal import Console, bound_text, digits, estimate, unit_text
from tuner.experiments.compare.words import flights_of
from tuner.extensions.contests.documents import ContestDocument

if TYPE_CHECKING:
    from tuner.extensions.contests.documents import ContestPlanDocument
    from tuner.extensions.contests.results import ContestResults


def print_contest(results: "ContestResults", console: Console) -> None:
    """Print what a contest found, whose page may still be drawn."""
    print_estimates(results.document, console)
    say_files(console, Report=results.home / "report.html")


def show_contest(results: "ContestResults", console: Console) -> None:
    """Print a contest."""
    console.print(results.title, style="bold")
    print_estimates(results.document, console)
    page = results.home / "report.html"
    say_files(console, **({"Report": page} if page.exists() else {"Results": results.home}))


def print_estimates(document: ContestDocument, console: Console) -> None:
    """Print the tables, sentences and warnings of a contest.json."""
    print_ending(document.ending, console)
    console.print(estimates_table(document))
    if document.published:
        console.print(published_table(document))
    console.bullets(document.words)
    console.warn(document.warnings)
    console.print(f"{document.flights:,} flights in {document.wall_seconds:.1f} s.")


def estimates_table(document: ContestDocument) -> TerminalTable:
    """Return contenders down, objectives and constraints across, each value over its interval."""
    flights = sum(entry.flights for entry in document.compared_on)
    table = TerminalTable(f"On {flights} {flights_of(document.stream)} each, 95 % intervals", keys=1)
    table.add_column("", no_wrap=True)
    judged = [quantity for quantity in document.quantities if quantity.kind in ("objective", "constraint")]
    for quantity in judged:
        limit = "" if quantity.limit is None else f"{bound_text(quantity)} "
        table.add_column(f"{quantity.label}\n{limit}{unit_text(quantity.unit)}".rstrip(), justify="right")
    table.add_column("instructions\na step", justify="right")
    values = {(entry.contender, entry.quantity): entry for entry in document.estimates}
    for contender in document.contenders:
        cells = [with_count(estimate(row), row.count) for row in (values[contender.name, q.label] for q in judged)]
        processor = contender.cost.processor
        counted = f"{processor.instructions_step:.0f}\n{processor.target}" if processor else ""
        mark = "" if contender.feasible else " (infeasible)"
        table.add_row(f"{contender.name}\n{contender.point}{mark}", *cells, counted)
    return table


def published_table(document: ContestDocument) -> TerminalTable:
    """Return the printed numbers next to ours, contender by contender."""
    table = TerminalTable("Printed numbers and our flights")
    ours = ("printed", "ours, mean", "95 % of our flights", "percentile")
    table.columns_of("quantity", *ours, left=("quantity",), wrap=ours)
    for contender in document.contenders:
        cells = [cell for cell in document.published if cell.contender == contender.name]
        if cells:
            table.add_section()
            table.add_row(contender.name, style="bold")
        for cell in cells:
            mark = "" if cell.inside else " outside"
            width = cell.p97_5 - cell.p2_5
            table.add_row(
                f"  {cell.metric} {cell.unit}{' (fitted)' if cell.fitted else ''}",
                f"{cell.printed:g}",
                digits(cell.mean, width),
                f"{digits(cell.p2_5, width)} to {digits(cell.p97_5, width)}",
                f"{cell.percentile:.1f}{mark}",
            )
    return table


def print_contest_plan(document: "ContestPlanDocument", console: Console) -> None:
    """Print the plan of a contest: each run, the comparison, and all of it."""
    for name, run in document.runs.items():
        console.print(f"\n{name}", style="bold")
        show(run, console)
    compared, total = document.comparison, document.total
    table = plain_table("The contest takes at most")
    for name, run in document.runs.items():
        flights, seconds = run.flights.total_at_most, run.seconds.total_at_most
        table.add_row(f"tuning {name}", f"{flights:,} flights", f"{seconds:.0f} s")
    table.add_row(
        f"comparison of {compared.points_at_most} points on confirmation scenarios",
        f"{compared.flights_at_most:,} flights",
        f"{compared.seconds_at_most:.0f} s",
    )
    table.add_row("all of it", f"{total.flights_at_most:,} flights", f"{total.seconds_at_most:.0f} s")
    table.add_row("compilation, once", "", done_or(total.compilation_seconds))
    table.add_row("results folder", f"{1e-6 * total.disk_bytes_at_most:,.0f} MB", "")
    console.print(table)
