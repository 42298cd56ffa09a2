"""`tuner show`: a results folder in the terminal, for people on ssh; the report in short."""

from typing import TYPE_CHECKING

from rich.text import Text

from tuner.api.run_report import next_commands
from tuner.cli.printers.compare import print_comparison
from tuner.cli.printers.opinion import print_opinion
from tuner.cli.printers.tuning import finding_texts, print_ending, print_points, print_tables_of_run
from tuner.cli.tables import TerminalTable, say_files
from tuner.cli.terminal import Console, digits, unit_text, width
from tuner.documents.parts import Estimate
from tuner.documents.summary import PickedObjective, SelectionValues
from tuner.documents.tuning import DEFAULT, INTERVAL
from tuner.extension import added, load
from tuner.report.charts.text import front_lines
from tuner.report.verdict_text import verdict_text
from tuner.report.words import gap_words, laws_of
from tuner.store.manifest import NONE_YET

if TYPE_CHECKING:
    from tuner.api.results import ComparisonResults, TuningResults
    from tuner.api.run_report import Progress, RunReport
    from tuner.documents.tuning import TuningFolder

PLOT_WIDTH, PLOT_HEIGHT = 72, 16
MAX_POINTS = 12


def print_run_report(report: "RunReport", console: Console) -> None:
    """Print a run, finished or not, or a comparison."""
    if report.progress is not None:
        print_unfinished(report.progress, console)
    elif report.results is not None:
        kind = report.results.kind
        printer = PRINTERS[kind] if kind in PRINTERS else load(added("shows")[kind])
        printer(report.results, console)
    if not report.is_guarded:
        console.print(f"Of this folder: {NONE_YET}.")


def show_comparison(results: "ComparisonResults", console: Console) -> None:
    """Print a comparison."""
    print_comparison(results.document, console)
    say_files(console, Report=results.home / "report.html")


def show_tuning(results: "TuningResults", console: Console) -> None:
    """Print all of a finished tuning run, in the report's order."""
    summary = results.document
    console.print(results.title, style="bold")
    print_ending(summary.ending, console)
    console.print(setup_text(results))
    heading = "Found" if results.feasible else "Nearest to feasible, not recommended"
    section(console, heading, [verdict_text(results), f"Why the {results.shown_name}: {summary.pick.why}."])
    print_tables_of_run(summary, console)
    section(console, "Trade-off on held-out flights", [])
    print_points(results, console)
    print_front(results, console)
    section(console, "How far to trust it", trust_texts(results))
    console.warn(summary.warnings)
    for text in finding_texts(summary):
        console.print(text)
    if summary.opinion is not None:
        print_opinion(summary.opinion, console)
    section(console, "Next steps" if results.feasible else "Next steps; nothing to fly", next_commands(results))


PRINTERS = {
    "tuning": show_tuning,
    "comparison": show_comparison,
}
"""Kind of results of the core -> its printer; those of extensions are in their records."""


def print_unfinished(report: "Progress", console: Console) -> None:
    """Print how far a run came and how it goes on."""
    console.print(report.title, style="bold")
    for text in report.texts:
        console.print(text)
    if report.commands:
        section(console, "If no process is at it any more, go on with it", report.commands)
    else:
        console.print("If no process is at it any more, remove the folder and give the command again.")


def section(console: Console, name: str, lines: list[str]) -> None:
    """Print a heading and lines below it."""
    console.print(f"\n{name}", style="bold underline")
    for line in lines:
        console.print(line, soft_wrap=line.startswith("tuner "))


def setup_text(results: "TuningFolder") -> str:
    """Return gains, vehicle and objectives of the search, in a sentence."""
    resolved, summary = results.resolved, results.document
    objectives = f"To be made small: {', '.join(entry.label for entry in results.objectives)}."
    tried = (
        f"seed {resolved.seed}; {resolved.search.algorithm} tried {len(results.evaluated.number):,} candidates in "
        f"{summary.flights:,}"
    )
    count = len(results.variables)
    if summary.wall_seconds is None:
        return f"{count} variables, {tried} trials that another program made. {objectives}"
    laws = " and ".join(f"{law} ({loop})" for law, loop in laws_of(resolved))
    flown = resolved.airframe.name if resolved.airframe else resolved.plant.title.rstrip(".") if resolved.plant else ""
    return f"{count} gains of {laws} on {flown}, {tried} flights and {summary.wall_seconds:.0f} s. {objectives}"


def print_front(results: "TuningFolder", console: Console) -> None:
    """Print a plot of two objectives, or else a table of points."""
    if len(results.objectives) == 2:
        for line in front_lines(results, min(console.width, PLOT_WIDTH), PLOT_HEIGHT):
            console.print(line, no_wrap=True, overflow="crop")
        return
    console.print(front_table(results))


def front_table(results: "TuningFolder") -> TerminalTable:
    """Return rows of the default, the recommended and further front points.

    The further points are evenly along the front.
    """
    table, front = TerminalTable(box=None), results.held_out_front
    table.add_column("")
    for entry in results.objectives:
        table.add_column(Text(entry.label), justify="right")
    named = [row for row in front.shown_rows if front.roles[row]]
    others = [row for row in front.shown_rows if not front.roles[row]]
    step = -(-len(others) // MAX_POINTS) or 1
    for row in [*named, *others[::step]]:
        role = front.roles[row]
        values = [
            Estimate(*parts) for parts in zip(*(front.stored[part][row].tolist() for part in INTERVAL), strict=True)
        ]
        name = role if role == DEFAULT else f"{front.points[row]} {role}".rstrip()
        table.add_row(Text(name), *[digits(value.value, width(value)) for value in values])
    return table


def trust_texts(results: "TuningFolder") -> list[str]:
    """Return the evidence behind the numbers, and the optimism of the search."""
    summary, history = results.document, results.progress
    texts = [
        f"Default and tuned flew {summary.held_out:,} confirmation flights each, which decided nothing; "
        "[..]: 95 % intervals, differences paired flight by flight."
    ]
    picked = summary.picked_on
    if picked is not None:
        texts += [gap_text(picked, row) for row in picked.objectives]
        texts.append(
            f"It is on the front in {100.0 * picked.probability:.0f} % of the resamples of the held-out flights."
        )
    feasible, volume = history.feasible_share[-1], history.hypervolume[-1]
    texts.append(
        f"{len(history.generation)} generations, {100.0 * feasible:.0f} % of the last one feasible; front of "
        f"{summary.front_size} points, hypervolume {volume:.4f}."
    )
    return texts


def gap_text(picked: SelectionValues, row: PickedObjective) -> str:
    """Return a sentence on the recommended point's objective, searched and held out."""
    gap, held, room = row.gap, row.held_out, width(row.held_out)
    unit = unit_text(row.unit, " {}")
    return (
        f"{row.label}: {digits(row.search, room)}{unit} in the search, {digits(held.value, room)}{unit} held "
        f"out, gap {digits(gap.value, room)} [{digits(gap.low, room)}, {digits(gap.high, room)}]: {gap_words(picked, gap)}."
    )
