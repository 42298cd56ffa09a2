"""`tuner show`: the story of a results folder in the terminal, for people on ssh; what the page of the report tells at length."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.text import Text

from plant.errors import StoreError
from tuner.api.frames import json_text
from tuner.cli.printers.compare import block_table, print_comparison
from tuner.cli.printers.contest import print_found
from tuner.cli.printers.inference import print_tables
from tuner.cli.printers.tuning import print_ending
from tuner.cli.tables import Table, say_files
from tuner.cli.terminal import Console, difference, digits, estimate
from tuner.documents.contest_document import ComparisonDocument, ContestDocument
from tuner.documents.inference_document import InferenceDocument
from tuner.documents.opening import open_results
from tuner.documents.parts import Estimate
from tuner.documents.summary import PickedOn
from tuner.experiments.registry import folder_kind
from tuner.report.terminal.tuning import tuning_story
from tuner.report.terminal.unfinished import unfinished_story
from tuner.store.advice import RECORD
from tuner.store.manifest import NONE_YET, read_manifest, refuse_damage, unfinished
from tuner.text.units import in_shown_units

if TYPE_CHECKING:
    from tuner.documents.tuning import TuningFolder

Row = dict[str, Any]
PLOT_WIDTH, PLOT_HEIGHT, BAR = 72, 16, 16
MOST_POINTS = 12
# What is not shown, and is large: flights are told by the digests in their names, whenever they are read.
UNREAD = ("flights/",)


def tell_folder(folder: Path, as_json: bool) -> None:
    """Print the story of a run, finished or not, of a contest, an inference or a comparison."""
    if not folder.is_dir():
        raise StoreError(f"{folder}: there is no such results folder; give a folder that `tuner run` wrote")
    refuse_damage(folder, UNREAD)
    console, kind, begun = Console(), folder_kind(folder), unfinished(folder)
    if begun or kind is None or not (folder / kind.document).exists():
        if not begun:
            refuse_other(folder)
        tell_story(unfinished_story(folder), None, as_json, console)
        return
    tell = TELLERS.get(kind.name)
    if tell is None:
        tell_story(*tuning_story(folder), as_json, console)
    else:
        found = open_results(folder).document
        if as_json:
            print(json_text(found, ascii_only=False))
        else:
            tell(found, folder, console)
    if not as_json:
        tell_unguarded(folder, console)


def refuse_other(folder: Path) -> None:
    """Refuse a complete folder that is none of a run: its numbers stand in one document and need no story."""
    manifest = read_manifest(folder)
    if manifest is not None and manifest.complete and RECORD not in manifest.files:
        documents = [str(folder / name) for name in manifest.files if name.endswith(".json") and "/" not in name]
        raise StoreError(
            f"{folder} is complete, but not the folder of a run; what was found is in {', '.join(documents)}"
        )


def tell_story(story: Row, results: "TuningFolder | None", as_json: bool, console: Console) -> None:
    """Print the story of a tuning run, as JSON if asked for; results: behind it, None where the run is not finished."""
    if as_json:
        print(json_text(story, ascii_only=False))
    elif results is not None:
        tell_tuning(story, results, console)
    else:
        tell_unfinished(story, console)


def tell_unguarded(folder: Path, console: Console) -> None:
    """Say where nothing tells damage."""
    if read_manifest(folder) is None:
        say(console, f"Of this folder: {NONE_YET}.")


def tell_contest(found: ContestDocument, folder: Path, console: Console) -> None:
    """Print the main tables of a contest."""
    head(console, found.title)
    print_found(found, folder, console)


def tell_inference(found: InferenceDocument, folder: Path, console: Console) -> None:
    """Print the main tables of an inference."""
    head(console, found.title)
    print_tables(found, console)
    say(console, f"{found.flights:,} flights.")
    say_files(console, Study=folder / "inferred.toml")


def tell_compared(found: ComparisonDocument, folder: Path, console: Console) -> None:
    """Print a comparison."""
    print_comparison(found, console)
    say_files(console, Report=folder / "report.html")


TELLERS: dict[str, Callable[[Any, Path, Console], None]] = {
    "contest": tell_contest,
    "inference": tell_inference,
    "comparison": tell_compared,
}
"""Kinds of folders whose document is told as it stands; the others are tuning runs."""


def tell_unfinished(story: Row, console: Console) -> None:
    """Print how far a run came and how it goes on."""
    head(console, story["title"])
    if "generations_done" in story:
        say(console, f"Not finished: {story['generations_done']} of {story['generations'] or 'its'} generations, "
                     f"{story['flights']:,} flights in {story['seconds']:.0f} s.")  # fmt: skip
        if story["generations_done"]:
            say(console, f"Feasible {100.0 * story['feasible_share']:.0f} %, hypervolume {story['hypervolume']:.4f}.")
    else:
        for key, said in (("contenders_finished", "Tuned"), ("contenders_begun", "Begun")):
            say(console, f"{said}: {', '.join(story[key]) or 'none'}")
    if story["commands"]:
        section(console, "If no process is at it any more, go on with it", story["commands"])
    else:
        say(console, "If no process is at it any more, remove the folder and give the command again.")


def tell_tuning(story: Row, results: "TuningFolder", console: Console) -> None:
    """Print everything of a finished run, in the order of the report."""
    head(console, story["title"])
    print_ending(story["ending"], console)
    say(console, asked_text(story["asked"]))
    section(console, *found_text(story))
    for row in map(in_shown_units, story["table"]):
        console.print(f"\n{heading(row)}", style="bold")
        console.print(block_table(default_and_tuned(row, story["shown_as"]), console.width))
    section(console, f"Gains (D default, @ {story['shown_as']}, within the range searched)", [])
    console.print(gains_table(story["gains"], console.width, story["shown_as"]))
    section(console, "Trade-off on held-out flights", [])
    tell_front(story, results, console)
    section(console, "How far to trust it", trust_texts(story))
    console.warn(story["warnings"])
    for text in story["remarks"]:
        say(console, text)
    section(console, "What to fly" if story["feasible"] else "What to look at; nothing to fly", story["commands"])


def found_text(story: Row) -> tuple[str, list[str]]:
    """Return heading and line of the point beside the default."""
    shown = story["recommended"] or story["nearest"]
    heading = "Found" if story["feasible"] else "Nearest to feasible, not recommended"
    return heading, [f"{shown['point']}: {shown['why']}."]


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


def asked_text(asked: Row) -> str:
    """Return what was asked in a sentence."""
    return (
        f"{len(asked['searched'])} gains of {asked['laws']['attitude']} (attitude) and {asked['laws']['position']} (position) "
        f"on {asked['airframe']}, seed {asked['seed']}; {asked['algorithm']} tried {asked['candidates']:,} candidates in "
        f"{asked['flights']:,} flights and {asked['wall_seconds']:.0f} s. To be made small: {', '.join(asked['objectives'])}."
    )


def heading(row: Row) -> str:
    """Return label, unit and limit of a row of the table."""
    unit = "" if row["unit"] == "1" else f" [{row['unit']}]"
    limit = "" if row["limit"] is None else f", at {row.get('sense') or 'most'} {row['limit']:g}"
    automatic = f" (automatic: {row['automatic']})" if row.get("automatic") else ""
    return f"{row['label']}{unit}{limit}{automatic}"


def default_and_tuned(row: Row, shown_as: str) -> list[list[str]]:
    """Return default and the point beside it as rows: name, value, difference, verdict."""
    return [
        ["default", estimate(Estimate(**row["default"])), "", ""],
        [shown_as, estimate(Estimate(**row["tuned"])), difference(Estimate(**row["difference"])), row["verdict"]],
    ]


def gains_table(gains: list[Row], width: int, shown_as: str) -> Table:
    """Return the searched gains with units and their place in the range."""
    from tuner.report.charts.text import place_bar

    table = Table(box=None)
    table.columns_of("gain", "default", shown_as, left=["gain"])
    table.add_column("unit")
    # The bar is longer than the ends of the range where there is room, else it goes.
    wide = width >= 72
    table.add_column("range", no_wrap=True)
    for row in gains:
        ends = f"{row['low']:g} {place_bar(row['place'], row['default_place'], BAR)} {row['high']:g}" if wide else (
            place_bar(row["place"], row["default_place"], BAR // 2))  # fmt: skip
        unit = "" if row["unit"] == "1" else row["unit"]
        table.add_row(Text(row["name"]), f"{row['default']:.4g}", f"{row['tuned']:.4g}", Text(unit), ends)
    return table


def tell_front(story: Row, results: "TuningFolder", console: Console) -> None:
    """Print a plot of two objectives, a table of the points for any other number."""
    if len(results.objectives) == 2:
        from tuner.report.charts.text import front_lines

        for line in front_lines(results, min(console.width, PLOT_WIDTH), PLOT_HEIGHT):
            console.print(line, no_wrap=True, overflow="crop")
        return
    console.print(front_table(story["front"], [entry.label for entry in results.objectives]))


def front_table(rows: list[Row], labels: list[str]) -> Table:
    """Return default, recommended and further points of the front, evenly among them, a row each."""
    table = Table(box=None)
    for name in ("", *labels):
        table.add_column(Text(name), justify="left" if not name else "right")
    named = [row for row in rows if row["role"]]
    others = [row for row in rows if not row["role"]]
    step = -(-len(others) // MOST_POINTS) or 1
    for row in [*named, *others[::step]]:
        name = row["role"] if row["role"] == "default" else f"{row['point']} {row['role']}".rstrip()
        values = [row["values"][label] for label in labels]
        table.add_row(Text(name), *[digits(v["value"], v["high"] - v["low"] or v["value"]) for v in values])
    return table


def trust_texts(story: Row) -> list[str]:
    """Return what the numbers rest on and how optimistic the search was."""
    from tuner.report.words import gap_words

    trust = story["trust"]
    said = [
        f"Default and tuned flew {story['confirmation_flights']:,} confirmation flights each, which decided nothing; "
        "[..]: 95 % intervals, differences paired flight by flight."
    ]
    picked = trust["picked_on"]
    for row in picked["objectives"] if picked else []:
        gap, held = row["gap"], row["held_out"]
        width = held["high"] - held["low"] or held["value"]
        unit = "" if row["unit"] == "1" else f" {row['unit']}"
        said.append(
            f"{row['label']}: {digits(row['search'], width)}{unit} in the search, {digits(held['value'], width)}{unit} held "
            f"out, gap {digits(gap['value'], width)} [{digits(gap['low'], width)}, {digits(gap['high'], width)}]: "
            f"{gap_words(PickedOn.model_validate(picked), Estimate(**gap))}."
        )
    if picked:
        said.append(
            f"It is on the front in {100.0 * picked['probability']:.0f} % of the resamples of the held-out flights."
        )
    said.append(
        f"{trust['generations']} generations, {100.0 * trust['feasible_share']:.0f} % of the last one feasible; front of "
        f"{trust['front_size']} points, hypervolume {trust['hypervolume']:.4f}."
    )
    return said
