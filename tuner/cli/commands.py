"""The commands that need no file of their own: run, bench, new, report."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from plant.errors import InputError, StoreError
from plant.input_files import read_input_text
from plant.texts import toml_table
from tuner.cli.display import MessageWatcher, TerminalWatcher, comparison_table, gains_table, print_ending
from tuner.cli.tables import say_files
from tuner.cli.terminal import Console
from tuner.documents.ending import gains_name
from tuner.search.watcher import Watcher
from tuner.text.errors import NOTHING_FEASIBLE

if TYPE_CHECKING:
    from tuner.experiments.registry import CompletedRun
    from tuner.experiments.tuning.outcome import Outcome


def overrides(changes: list[str]) -> dict[str, Any]:
    """Turn KEY=VALUE texts into values; a value is read as TOML, and as plain text where it is none."""
    parsed: dict[str, Any] = {}
    for change in changes:
        key, equals, text = change.partition("=")
        if not equals or not key:
            raise InputError(f"given '{change}'; write KEY=VALUE, for instance search.generations=3", key="--set")
        try:
            parsed[key] = toml_table(f"value = {text}", Path("--set"))["value"]
        except InputError:
            parsed[key] = text
    return parsed


def run_command(
    study: Path,
    out: Path | None,
    threads: int | None,
    changes: list[str],
    reuse: list[Path],
    as_json: bool,
    dask: str | None = None,
    backend: str = "lanes",
) -> None:
    """Run a study of any kind and print what it found."""
    from tuner.experiments.registry import run
    from tuner.study.kinds import load_any

    asked = load_any(study, overrides(changes))
    print_run(
        lambda watcher: run(asked, out, watcher, threads=threads, reuse=tuple(reuse), dask=dask, backend=backend),
        as_json,
    )


def print_run(start: "Callable[[Watcher], CompletedRun]", as_json: bool) -> None:
    """Carry out a run with progress on the terminal and print what it found, or its document as JSON and nothing else.

    Ends with `NOTHING_FEASIBLE` where no candidate keeps every limit.
    """
    from tuner.cli.contest import print_contest
    from tuner.cli.inference import print_inference

    if as_json:
        done = start(MessageWatcher(Console(stderr=True)))
        print(read_input_text(done.document))
    else:
        console = Console()
        with TerminalWatcher(console) as watcher:
            done = start(watcher)
        told = {"contest": print_contest, "inference": print_inference}.get(done.kind.name, print_tuning)
        told(done, console)
    if not done.feasible:
        raise typer.Exit(NOTHING_FEASIBLE)


def print_tuning(done: "CompletedRun", console: Console) -> None:
    """Print what a tuning run or a second judgement found."""
    outcome: Outcome = done.found
    summary = json.loads(read_input_text(done.document))
    print_ending(summary, console)
    console.print(gains_table(summary))
    console.print(comparison_table(summary))
    if done.feasible:
        console.print(f"Recommended: {summary['tuned']}: {summary['pick']['why']}.", highlight=False)
    for warning in summary["warnings"]:
        console.print(f"Warning: {warning}", style="yellow", highlight=False)
    for text in summary["remarks"]:
        console.print(text, highlight=False)
    if outcome.study.requirements:
        screened = summary["screened"]
        console.print(
            f"Not worth a flight, for they break a hard requirement: {screened['candidates']:,} candidates; "
            f"{screened['flights']:,} flights saved.",
            highlight=False,
        )
    raced = summary["raced"]
    if raced["candidates"]:
        console.print(
            f"Races that ended early: {raced['candidates']:,} candidates; {raced['flights']:,} flights saved.",
            highlight=False,
        )
    made = outcome.problem.flights_made
    now = "" if made == outcome.flights else f" ({made:,} flights flown now, the others were there)"
    console.print(f"{outcome.flights:,} flights{now} in {outcome.seconds:.1f} s.", highlight=False)
    files = {"Gains" if done.feasible else "Gains (infeasible)": done.path / gains_name(done.feasible)}
    say_files(console, Report=done.path / "report.html", **files)


def bench_command(flights: int, threads: int | None, as_json: bool) -> None:
    """Measure and print the speed of the backends."""
    from tuner.engines.speed import bench

    console = Console(stderr=as_json)
    if not as_json:
        console.print("Measuring closed-loop plant steps per second; the first run on a machine compiles two kernels.")
    figures = bench(flights, threads)
    if as_json:
        print(json.dumps(figures, indent=2))
        return
    for key, value in figures.items():
        shown = f"{value:,.3g}" if isinstance(value, float) else str(value)
        console.print(f"{key:28} {shown}", highlight=False)


def new_command(name: str, source: Path | None) -> None:
    """Write the commented study template, or a copy of a study."""
    from tuner.study.files import copied_study
    from tuner.study.template import TEMPLATE

    path = Path(name if name.endswith(".toml") else f"{name}.toml")
    title = "".join(letter for letter in path.stem.replace("_", " ") if letter not in '"\\')
    text = TEMPLATE.replace("@TITLE@", title) if source is None else copied_study(source, path)
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise StoreError(f"{path} exists already and was not touched; choose another name") from None
    except OSError as error:
        raise StoreError(f"{path} cannot be written ({error.strerror})") from None
    print(f"Wrote {path}. Run it with: tuner run {path}")


def report_command(results: Path) -> None:
    """Write report and figures of a results folder again, of whatever kind it is."""
    from tuner.experiments.registry import draw

    print(draw(results))
