"""The commands that need no file of their own: run, bench, new, check, report."""

import json
import tomllib
from pathlib import Path
from typing import Any

from rich.console import Console

from plant.errors import InputError, StoreError
from tuner.cli.display import TerminalWatcher, comparison_table, gains_table
from tuner.study import load_study
from tuner.watcher import Watcher


def overrides(changes: list[str]) -> dict[str, Any]:
    """Turn KEY=VALUE texts into values; a value is read as TOML, and as plain text where it is none."""
    parsed: dict[str, Any] = {}
    for change in changes:
        key, equals, text = change.partition("=")
        if not equals or not key:
            raise InputError(f"given '{change}'; write KEY=VALUE, for instance search.generations=3", key="--set")
        try:
            parsed[key] = tomllib.loads(f"value = {text}")["value"]
        except tomllib.TOMLDecodeError:
            parsed[key] = text
    return parsed


def run_command(study: Path, out: Path | None, threads: int | None, changes: list[str], as_json: bool) -> None:
    """Run a study and print the Default / Tuned table."""
    asked = load_study(study, overrides(changes))
    if not asked.space.variables:
        raise InputError(
            'no gain is searched; give at least one a range, for instance "attitude.lambda" = {}',
            file=study,
            key="gains",
        )
    from tuner.run import default_folder, run_study
    from tuner.store.folder import Folder

    folder = Folder.create(out or default_folder(asked))
    if as_json:
        run_study(asked, folder, Watcher(), threads)
        print((folder.path / "summary.json").read_text(encoding="utf-8"))
        return
    console = Console()
    console.print(f"[bold]{asked.title}[/bold]  (seed {asked.seed})", highlight=False)
    with TerminalWatcher(console) as watcher:
        outcome = run_study(asked, folder, watcher, threads)
    summary = json.loads((folder.path / "summary.json").read_text(encoding="utf-8"))
    console.print(gains_table(summary))
    console.print(comparison_table(summary))
    console.print(f"Recommended: {summary['tuned']}: {summary['pick']['why']}.", highlight=False)
    for warning in summary["warnings"]:
        console.print(f"Warning: {warning}", style="yellow", highlight=False)
    console.print(
        f"{outcome.flights:,} flights in {outcome.seconds:.1f} s. "
        f"Report: {folder.path / 'report.html'}  Gains: {folder.path / 'gains.json'}",
        highlight=False, soft_wrap=True,
    )  # fmt: skip


def bench_command(flights: int, threads: int | None, as_json: bool) -> None:
    """Measure and print the speed of the backends."""
    from tuner.bench import bench

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


def new_command(name: str) -> None:
    """Write the commented study template."""
    from tuner.study.template import TEMPLATE

    path = Path(name if name.endswith(".toml") else f"{name}.toml")
    title = "".join(letter for letter in path.stem.replace("_", " ") if letter not in '"\\')
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(TEMPLATE.replace("@TITLE@", title))
    except FileExistsError:
        raise StoreError(f"{path} exists already and was not touched; choose another name") from None
    except OSError as error:
        raise StoreError(f"{path} cannot be written ({error.strerror})") from None
    print(f"Wrote {path}. Run it with: tuner run {path}")


def check_command(study: Path, as_json: bool) -> None:
    """Say what a study would fly, or what is wrong with it."""
    asked = load_study(study)
    flights = asked.search.generations * asked.search.population * sum(entry.search for entry in asked.scenarios)
    figures = {
        "title": asked.title,
        "variables": len(asked.space.variables),
        "objectives": [objective.label for objective in asked.objectives],
        "constraints": [constraint.objective.label for constraint in asked.constraints],
        "search_flights": flights,
        "digest": asked.digest(),
    }
    if as_json:
        print(json.dumps(figures, indent=2))
        return
    for key, value in figures.items():
        print(f"{key:16} {', '.join(value) if isinstance(value, list) else value}")


def report_command(results: Path) -> None:
    """Write report and figures of a results folder again."""
    if not (results / "summary.json").exists():
        raise StoreError(f"{results} is no finished results folder: it holds no summary.json")
    from tuner.report import write_figures, write_report

    write_figures(results)
    print(write_report(results))
