"""`tuner show`: the story of a results folder in the terminal, for people on ssh; what the page of the report tells at length."""

from typing import TYPE_CHECKING

from rich.text import Text

from tuner.api.story import AskedPart, FrontPoint, PlacedGain, TuningStory, UnfinishedContest, UnfinishedRun
from tuner.cli.printers.compare import block_table, print_comparison
from tuner.cli.printers.contest import print_found
from tuner.cli.printers.inference import print_tables
from tuner.cli.printers.tuning import print_ending, with_count
from tuner.cli.tables import TerminalTable, say_files
from tuner.cli.terminal import Console, difference, digits, estimate, limit_text, unit_text, width
from tuner.documents.contest_document import ComparisonDocument, ContestDocument
from tuner.documents.inference_document import InferenceDocument
from tuner.documents.parts import in_shown_units
from tuner.documents.summary import PickedObjective, PickedOn, TableRow
from tuner.report.charts.text import front_lines, place_bar
from tuner.report.words import gap_words, loss_words, uncertainty_words
from tuner.store.manifest import NONE_YET

if TYPE_CHECKING:
    from tuner.api.story import Story
    from tuner.documents.tuning import TuningFolder

PLOT_WIDTH, PLOT_HEIGHT, BAR = 72, 16, 16
MOST_POINTS = 12


def print_story(story: "Story", console: Console) -> None:
    """Print the story of a run, finished or not, of a contest, an inference or a comparison."""
    document = story.document
    if isinstance(document, ComparisonDocument):
        print_comparison(document, console)
        say_files(console, Report=story.folder / "report.html")
    elif isinstance(document, ContestDocument):
        head(console, document.title)
        print_found(document, story.folder, console)
    elif isinstance(document, InferenceDocument):
        head(console, document.title)
        print_tables(document, console)
        say(console, f"{document.flights:,} flights.")
        say_files(console, Study=story.folder / "inferred.toml")
    elif story.results is not None:
        tell_tuning(document, story.results, console)
    else:
        tell_unfinished(document, console)
        return
    if not story.guarded:
        say(console, f"Of this folder: {NONE_YET}.")


def tell_unfinished(story: UnfinishedRun | UnfinishedContest, console: Console) -> None:
    """Print how far a run came and how it goes on."""
    head(console, story.title)
    if isinstance(story, UnfinishedContest):
        say(console, f"Tuned: {', '.join(story.contenders_finished) or 'none'}")
        say(console, f"Begun: {', '.join(story.contenders_begun) or 'none'}")
    else:
        say(console, f"Not finished: {story.generations_done} of {story.generations or 'its'} generations, "
                     f"{story.flights:,} flights in {story.seconds:.0f} s.")  # fmt: skip
        if story.feasible_share is not None:
            say(console, f"Feasible {100.0 * story.feasible_share:.0f} %, hypervolume {story.hypervolume:.4f}.")
    if story.commands:
        section(console, "If no process is at it any more, go on with it", story.commands)
    else:
        say(console, "If no process is at it any more, remove the folder and give the command again.")


def tell_tuning(story: TuningStory, results: "TuningFolder", console: Console) -> None:
    """Print everything of a finished run, in the order of the report."""
    head(console, story.title)
    print_ending(story.ending, console)
    say(console, asked_text(story.asked))
    section(console, *found_text(story))
    for row in map(in_shown_units, story.table):
        console.print(f"\n{heading(row)}", style="bold")
        console.print(block_table(default_and_tuned(row, story.shown_as), console.width))
    section(console, f"Gains (D default, @ {story.shown_as}, within the range searched)", [])
    console.print(gains_table(story.gains, console.width, story.shown_as))
    section(console, "Trade-off on held-out flights", [])
    tell_front(story, results, console)
    section(console, "How far to trust it", trust_texts(story))
    console.warn(story.warnings)
    for text in (*loss_words(results.summary), *story.remarks, *map(uncertainty_words, results.summary.uncertainty)):
        say(console, text)
    section(console, "What to fly" if story.feasible else "What to look at; nothing to fly", story.commands)


def found_text(story: TuningStory) -> tuple[str, list[str]]:
    """Return heading and line of the point beside the default."""
    shown = story.recommended or story.nearest
    heading = "Found" if story.feasible else "Nearest to feasible, not recommended"
    return heading, [] if shown is None else [f"{shown.point}: {shown.why}."]


def head(console: Console, title: str) -> None:
    """Print the title."""
    console.print(title, style="bold")


def say(console: Console, text: str) -> None:
    """Print a line as it is."""
    console.print(text)


def section(console: Console, name: str, lines: list[str]) -> None:
    """Print a heading and lines below it."""
    console.print(f"\n{name}", style="bold underline")
    for line in lines:
        console.print(line, soft_wrap=line.startswith("tuner "))


def asked_text(asked: AskedPart) -> str:
    """Return what was asked in a sentence."""
    wanted = f"To be made small: {', '.join(asked.objectives)}."
    tried = f"seed {asked.seed}; {asked.algorithm} tried {asked.candidates:,} candidates in {asked.flights:,}"
    if asked.wall_seconds is None:
        return f"{len(asked.searched)} variables, {tried} trials that another program made. {wanted}"
    cascade = {} if asked.laws is None else {"attitude": asked.laws.attitude, "position": asked.laws.position}
    laws = " and ".join(f"{law} ({loop})" for loop, law in (asked.channels or cascade).items())
    flown = asked.airframe or (asked.plant or "").rstrip(".")
    return f"{len(asked.searched)} gains of {laws} on {flown}, {tried} flights and {asked.wall_seconds:.0f} s. {wanted}"


def heading(row: TableRow) -> str:
    """Return label, unit and limit of a row of the table."""
    limit = "" if row.limit is None else f", {limit_text(row)}"
    automatic = getattr(row, "automatic", "")
    return f"{row.label}{unit_text(row.unit, ' [{}]')}{limit}{f' (automatic: {automatic})' if automatic else ''}"


def default_and_tuned(row: TableRow, shown_as: str) -> list[list[str]]:
    """Return default and the point beside it as rows: name, value, difference, verdict."""
    default, tuned = getattr(row, "default_count", None), getattr(row, "tuned_count", None)
    return [
        ["default", with_count(estimate(row.default), default), "", ""],
        [shown_as, with_count(estimate(row.tuned), tuned), difference(row.difference), row.verdict],
    ]


def gains_table(gains: list[PlacedGain], width: int, shown_as: str) -> TerminalTable:
    """Return the searched gains with units and their place in the range."""
    table = TerminalTable(box=None)
    table.columns_of("gain", "default", shown_as, left=("gain",))
    table.add_column("unit")
    # The bar is longer than the ends of the range where there is room, else it goes.
    wide = width >= 72
    table.add_column("range", no_wrap=True)
    for row in gains:
        bar = place_bar(row.place, row.default_place, BAR if wide else BAR // 2)
        ends = f"{row.low:g} {bar} {row.high:g}" if wide else bar
        table.add_row(Text(row.name), f"{row.default:.4g}", f"{row.tuned:.4g}", Text(unit_text(row.unit)), ends)
    return table


def tell_front(story: TuningStory, results: "TuningFolder", console: Console) -> None:
    """Print a plot of two objectives, a table of the points for any other number."""
    if len(results.objectives) == 2:
        for line in front_lines(results, min(console.width, PLOT_WIDTH), PLOT_HEIGHT):
            console.print(line, no_wrap=True, overflow="crop")
        return
    console.print(front_table(story.front, story.asked.objectives))


def front_table(rows: list[FrontPoint], labels: list[str]) -> TerminalTable:
    """Return default, recommended and further points of the front, evenly among them, a row each."""
    table = TerminalTable(box=None)
    for name in ("", *labels):
        table.add_column(Text(name), justify="left" if not name else "right")
    named = [row for row in rows if row.role]
    others = [row for row in rows if not row.role]
    step = -(-len(others) // MOST_POINTS) or 1
    for row in [*named, *others[::step]]:
        name = row.role if row.role == "default" else f"{row.point} {row.role}".rstrip()
        values = [row.values[label] for label in labels]
        table.add_row(Text(name), *[digits(v.value, width(v)) for v in values])
    return table


def trust_texts(story: TuningStory) -> list[str]:
    """Return what the numbers rest on and how optimistic the search was."""
    trust = story.trust
    said = [
        f"Default and tuned flew {story.confirmation_flights:,} confirmation flights each, which decided nothing; "
        "[..]: 95 % intervals, differences paired flight by flight."
    ]
    picked = trust.picked_on
    if picked is not None:
        said += [gap_text(picked, row) for row in picked.objectives]
        said.append(
            f"It is on the front in {100.0 * picked.probability:.0f} % of the resamples of the held-out flights."
        )
    said.append(
        f"{trust.generations} generations, {100.0 * trust.feasible_share:.0f} % of the last one feasible; front of "
        f"{trust.front_size} points, hypervolume {trust.hypervolume:.4f}."
    )
    return said


def gap_text(picked: PickedOn, row: PickedObjective) -> str:
    """Return an objective of the recommended point in the search and held out, in a sentence."""
    gap, held, room = row.gap, row.held_out, width(row.held_out)
    unit = unit_text(row.unit, " {}")
    return (
        f"{row.label}: {digits(row.search, room)}{unit} in the search, {digits(held.value, room)}{unit} held "
        f"out, gap {digits(gap.value, room)} [{digits(gap.low, room)}, {digits(gap.high, room)}]: {gap_words(picked, gap)}."
    )
