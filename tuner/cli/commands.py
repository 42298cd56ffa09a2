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
    """Run a study and print the Default / Tuned table; a file with contenders is a contest, one with unknowns an inference."""
    from tuner.contest import is_contest
    from tuner.inference import is_inference

    if is_inference(study):
        from tuner.cli.inference import run_inference_command

        run_inference_command(study, out, threads, overrides(changes), as_json)
        return
    if is_contest(study):
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
    if outcome.study.requirements:
        screened = summary["screened"]
        console.print(
            f"Not worth a flight, for they break a hard requirement: {screened['candidates']:,} candidates; "
            f"{screened['flights']:,} flights saved.",
            highlight=False,
        )
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
    """Say what a study, a contest or an inference would fly, or what is wrong with it."""
    from tuner.contest import is_contest
    from tuner.inference import is_inference

    if is_inference(study):
        from tuner.cli.inference import check_inference

        figures = check_inference(study)
    elif is_contest(study):
        from tuner.cli.contest import check_contest

        figures = check_contest(study)
    else:
        figures = check_study(study)
    if as_json:
        print(json.dumps(figures, indent=2))
        return
    for key, value in figures.items():
        print(f"{key:18} {', '.join(value) if isinstance(value, list) else value}")


def check_study(study: Path) -> dict[str, Any]:
    """Return what a study would fly; InputError where it is wrong."""
    asked = load_study(study)
    flights = asked.search.generations * asked.search.population * sum(entry.search for entry in asked.scenarios)
    return {
        "title": asked.title,
        "variables": len(asked.space.variables),
        "objectives": [objective.label for objective in asked.objectives],
        "constraints": [constraint.objective.label for constraint in asked.constraints],
        "requirements": [requirement.label for requirement in asked.requirements],
        "search_flights": flights,
        "digest": asked.digest(),
    }


def report_command(results: Path) -> None:
    """Write report and figures of a results folder again, be it of a study, a contest or an inference."""
    if (results / "contest.json").exists():
        from tuner.report.contest import write_contest_figures, write_contest_report

        write_contest_figures(results)
        print(write_contest_report(results))
        return
    if (results / "inference.json").exists():
        from tuner.inference.figure import write_inference_figures
        from tuner.report.contest import write_inference_report

        write_inference_figures(results)
        print(write_inference_report(results))
        return
    if not (results / "summary.json").exists():
        raise StoreError(f"{results} is no finished results folder: it holds no summary.json")
    from tuner.report import write_figures, write_report

    write_figures(results)
    print(write_report(results))
