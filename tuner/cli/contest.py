"""`tuner run` and `tuner check` on a contest: handlers and what they print."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from plant.input_files import read_input_text
from tuner.cli.display import TerminalWatcher, digits, estimate, print_ending
from tuner.cli.tables import Table, say_files
from tuner.cli.terminal import Console
from tuner.experiments.contest.words import flights_of
from tuner.experiments.tuning.conflicts import told_automatic
from tuner.search.watcher import Watcher
from tuner.study.contest import Contest
from tuner.study.contest_reading import load_contest
from tuner.text.errors import NOTHING_FEASIBLE

if TYPE_CHECKING:
    from tuner.store.folder import Folder


def run_contest_command(
    path: Path, out: Path | None, threads: int | None, overrides: dict[str, Any], as_json: bool
) -> None:
    """Run a contest and print what it found."""
    contest = load_contest(path, overrides)
    from tuner.experiments.contest.run import default_folder
    from tuner.store.folder import Folder

    folder = Folder.create(out or default_folder(contest), inside="contenders")
    print_contest(contest, folder, threads, as_json)


def print_contest(contest: Contest, folder: "Folder", threads: int | None, as_json: bool) -> None:
    """Run a contest in a folder with progress on the terminal and print what it found, or its document as JSON.

    Ends with `NOTHING_FEASIBLE` where the run of a contender finds no candidate that keeps every limit.
    """
    from tuner.experiments.contest.run import run_contest

    console = Console()
    if as_json:
        with folder:
            run_contest(contest, folder, Watcher(), threads)
    else:
        console.print(f"{contest.title}  (seed {contest.seed})", style="bold", highlight=False)
        for text in told_automatic(contest.base.constraints):
            console.print(text, highlight=False)
        with folder, TerminalWatcher(console) as watcher:
            run_contest(contest, folder, watcher, threads)
    text = read_input_text(folder.path / "contest.json")
    found = json.loads(text)
    if as_json:
        print(text)
    else:
        print_found(found, folder.path, console)
    if not found["feasible"]:
        raise typer.Exit(NOTHING_FEASIBLE)


def print_found(found: dict[str, Any], folder: Path, console: Console) -> None:
    """Print the tables, sentences and warnings of a contest.json."""
    print_ending(found, console)
    console.print(estimates_table(found))
    if found["published"]:
        console.print(published_table(found))
    for text in found["words"]:
        console.print(f"- {text}", highlight=False)
    for warning in found["warnings"]:
        console.print(f"Warning: {warning}", style="yellow", highlight=False)
    page = folder / "report.html"
    console.print(f"{found['flights']:,} flights in {found['wall_seconds']:.1f} s.", highlight=False)
    say_files(console, **({"Report": page} if page.exists() else {"Results": folder}))


def estimates_table(found: dict[str, Any]) -> Table:
    """Return contenders down, objectives and constraints across, each value over its interval."""
    flights = sum(entry["flights"] for entry in found["compared_on"])
    table = Table(f"On {flights} {flights_of(found['stream'])} each, 95 % intervals", keys=1)
    table.add_column("", no_wrap=True)
    judged = [quantity for quantity in found["quantities"] if quantity["kind"] in ("objective", "constraint")]
    for quantity in judged:
        unit = "" if quantity["unit"] == "1" else quantity["unit"]
        limit = "" if quantity["limit"] is None else f"at most {quantity['limit']:g} "
        table.add_column(f"{quantity['label']}\n{limit}{unit}".rstrip(), justify="right")
    table.add_column("instructions\na step", justify="right")
    values = {(entry["contender"], entry["quantity"]): entry for entry in found["estimates"]}
    for contender in found["contenders"]:
        cells = [estimate(values[contender["name"], quantity["label"]]) for quantity in judged]
        processor = contender["cost"].get("processor")
        counted = f"{processor['instructions_step']:.0f}\n{processor['target']}" if processor else ""
        mark = "" if contender.get("feasible", True) else " (infeasible)"
        table.add_row(f"{contender['name']}\n{contender['point']}{mark}", *cells, counted)
    return table


def published_table(found: dict[str, Any]) -> Table:
    """Return the printed numbers beside ours, contender by contender."""
    table = Table("Printed numbers and our flights")
    for name in ("quantity", "printed", "ours, mean", "95 % of our flights", "percentile"):
        table.add_column(name, justify="left" if name == "quantity" else "right", no_wrap=name == "quantity")
    for contender in found["contenders"]:
        cells = [cell for cell in found["published"] if cell["contender"] == contender["name"]]
        if cells:
            table.add_section()
            table.add_row(contender["name"], style="bold")
        for cell in cells:
            mark = "" if cell["inside"] else " outside"
            width = cell["p97_5"] - cell["p2_5"]
            table.add_row(
                f"  {cell['metric']} {cell['unit']}{' (fitted)' if cell['fitted'] else ''}", f"{cell['value']:g}",
                digits(cell["mean"], width), f"{digits(cell['p2_5'], width)} to {digits(cell['p97_5'], width)}",
                f"{cell['percentile']:.1f}{mark}",
            )  # fmt: skip
    return table


def check_contest(path: Path) -> dict[str, Any]:
    """Return what a contest would fly; InputError where it is wrong."""
    from tuner.experiments.planning.contest import comparison_flights

    contest = load_contest(path)
    return {
        "title": contest.title,
        "contenders": [_described(contest, i) for i in range(len(contest.contenders))],
        "quantities": [quantity.label for quantity in contest.quantities],
        "published": len(contest.published),
        "claims": len(contest.claims),
        "search_flights": sum(_search_flights(contest, i) for i in range(len(contest.contenders))),
        "comparison_flights_at_most": comparison_flights(contest),
    }


def _described(contest: Contest, i: int) -> str:
    contender = contest.contenders[i]
    searched = len(contender.study.space.variables)
    return f"{contender.name} ({f'{searched} searched' if searched else 'as given'})"


def _search_flights(contest: Contest, i: int) -> int:
    study = contest.contenders[i].study
    if not contest.contenders[i].tuned:
        return 0
    return study.search.generations * study.search.population * sum(entry.search for entry in study.scenarios)
