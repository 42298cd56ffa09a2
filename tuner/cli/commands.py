"""The commands that need no file of their own: run, bench, new, report."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from plant.errors import InputError, StoreError
from plant.input_files import read_input_text
from plant.texts import toml_table
from tuner.cli.display import TerminalWatcher, comparison_table, gains_table, print_ending
from tuner.cli.tables import say_files
from tuner.cli.terminal import Console
from tuner.documents.ending import gains_name
from tuner.experiments.tuning.conflicts import told_automatic
from tuner.search.watcher import Watcher
from tuner.study import load_study
from tuner.study.trim import told_trim
from tuner.text.errors import NOTHING_FEASIBLE

if TYPE_CHECKING:
    from tuner.experiments.tuning.outcome import Outcome
    from tuner.store.folder import Folder
    from tuner.study.study import Study


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
    """Run a study and print the Default / Tuned table; a file with contenders is a contest, one with unknowns an inference."""
    from tuner.study.kinds import study_kind

    kind = study_kind(study).name
    several = kind != "tuning"
    for results in reuse:
        if not results.is_dir():
            raise InputError(f"there is no results folder {results}", key="--reuse")
    if reuse and several:
        raise InputError("only a tuning study takes flights over", key="--reuse")
    if dask is not None and several:
        raise InputError("only a tuning study flies on a cluster", key="--dask")
    check_backend(backend, several, dask)
    if kind == "inference":
        from tuner.cli.inference import run_inference_command

        run_inference_command(study, out, threads, overrides(changes), as_json)
        return
    if kind == "contest":
        from tuner.cli.contest import run_contest_command

        run_contest_command(study, out, threads, overrides(changes), as_json)
        return
    asked = load_study(study, overrides(changes))
    if not asked.space.variables:
        raise InputError(
            'no gain is searched; give at least one a range, for instance "attitude.lambda" = {}',
            file=study,
            key="gains",
        )
    from tuner.engines.cluster.connect import engine_at
    from tuner.engines.cuda import engine_named
    from tuner.experiments.again.resume import compute_as_reused
    from tuner.experiments.tuning.run import default_folder, run_study
    from tuner.store.folder import Folder

    console = Console(stderr=as_json)

    def say(text: str) -> None:
        console.print(text, highlight=False, soft_wrap=True)

    compute_as_reused(reuse)
    # Before the folder is made: where there is no cluster, nothing is left behind.
    with engine_at(dask, asked, threads, say) as cluster:
        engine = cluster or engine_named(backend, asked.system, asked.seed, say)
        folder = Folder.create(out or default_folder(asked))
        taken = tuple(reuse)
        print_run(asked, folder, as_json, lambda watcher: run_study(asked, folder, watcher, threads, taken, engine))


def check_backend(backend: str, several: bool, dask: str | None) -> None:
    """Refuse a backend that there is not, or not for this kind of study; several: it is a contest or an inference."""
    from tuner.engines.cuda import KEY, LANES, check

    check(backend)
    if backend != LANES and several:
        raise InputError("only a tuning study flies on a graphics card", key=KEY)
    if backend != LANES and dask is not None:
        raise InputError(f"given {backend}; the workers of a cluster fly lanes, so give --dask or --backend", key=KEY)


def print_run(asked: "Study", folder: "Folder", as_json: bool, run: "Callable[[Watcher], Outcome]") -> None:
    """Run a study with progress on the terminal and print what it found, or its summary as JSON and nothing else.

    Ends with `NOTHING_FEASIBLE` where no candidate keeps every limit.
    """
    if as_json:
        with folder:
            outcome = run(Watcher())
        print(read_input_text(folder.path / "summary.json"))
    else:
        outcome = watched_run(asked, folder, run)
    if not outcome.feasible:
        raise typer.Exit(NOTHING_FEASIBLE)


def watched_run(asked: "Study", folder: "Folder", run: "Callable[[Watcher], Outcome]") -> "Outcome":
    """Run a study with progress on the terminal and print what it found."""
    console = Console()
    console.print(f"{asked.title}  (seed {asked.seed})", style="bold", highlight=False)
    for text in (
        *told_trim([entry.spec for entry in asked.scenarios], asked.system),
        *told_automatic(asked.constraints),
    ):
        console.print(text, highlight=False)
    with folder, TerminalWatcher(console) as watcher:
        outcome = run(watcher)
    summary = json.loads(read_input_text(folder.path / "summary.json"))
    print_ending(summary, console)
    console.print(gains_table(summary))
    console.print(comparison_table(summary))
    if outcome.feasible:
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
    files = {"Gains" if outcome.feasible else "Gains (infeasible)": folder.path / gains_name(outcome.feasible)}
    say_files(console, Report=folder.path / "report.html", **files)
    return outcome


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
    """Write report and figures of a results folder again, be it of a study, a contest or an inference."""
    from tuner.documents.files import Node
    from tuner.store.folder import Folder

    known = ("summary.json", "contest.json", "comparison.json", "inference.json")
    found = [results / name for name in known if (results / name).exists()]
    if not found:
        raise StoreError(f"{results} is no finished results folder: it holds no summary.json")
    # What cannot be read is told before the folder is touched: a lock would stay behind.
    for file in found:
        Node.read(file)
    with Folder.open(results) as folder:
        page = draw_again(results)
        folder.amend("report.html", "figures/*")
    print(page)


def draw_again(results: Path) -> Path:
    """Write report and figures of a results folder from what is in it, and return the page."""
    if (results / "comparison.json").exists():
        from tuner.report.values_figure import write_values_figure

        write_values_figure(results)
    if (results / "contest.json").exists() or (results / "comparison.json").exists():
        from tuner.report.contest import write_contest_figures, write_contest_report

        write_contest_figures(results)
        return write_contest_report(results)
    if (results / "inference.json").exists():
        from tuner.report.contest import write_inference_report
        from tuner.report.inference_figure import write_inference_figures

        write_inference_figures(results)
        return write_inference_report(results)
    from tuner.report import write_figures, write_report

    write_figures(results)
    return write_report(results)
