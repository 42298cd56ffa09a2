"""Commands that read what was found: show, report, compare."""

from pathlib import Path
from typing import Annotated

import typer

import tuner
from plant.errors import InputError
from tuner.cli.answer import answer, progress
from tuner.cli.app import AsJson, Folder, Gain, Seeds, Threads, app, gains_of, study_option


@app.command()
def report(results: Folder) -> None:
    """Regenerate report.html and figures.

    Example: tuner report results/quickstart
    """
    print(tuner.open_results(results).report())


@app.command()
def compare(
    what: Annotated[
        list[Path],
        typer.Argument(
            help="Results folders, gains files, studies (their default); two or more.", metavar="RESULTS|GAINS"
        ),
    ],
    study: Annotated[
        Path | None, study_option("Fly the scenarios of this study; default: those of the first results folder.")
    ] = None,
    gain: Gain = None,
    seeds: Seeds = None,
    out: Annotated[Path | None, typer.Option(help="Write numbers, figures and a page into this new folder.")] = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Compare results or gains with the first, paired, on the same flights.

    With --gain, the first with other values of its gains is one more entrant.

    Example: tuner compare results/quickstart gains.json --seeds 256 --out comparison

    Example: tuner compare studies/dc_motor.toml --gain angle.kp=12
    """
    entrants: list[Path | tuner.Gains] = list(what)
    if gain:
        entrants.append(tuner.read_gains(what[0]).replace(gains_of(gain)))
    with progress(as_json) as watcher:
        result = tuner.compare(entrants, out, study=study, flights=seeds, watcher=watcher, threads=threads)
    answer(result, as_json)


@app.command()
def show(
    results: Annotated[Path, typer.Argument(help="A results folder, finished or not.", show_default=False)],
    table: Annotated[
        str | None,
        typer.Option(
            help="Print one table: objectives, limits, gains, front, margins; values, differences of a contest."
        ),
    ] = None,
    latex: Annotated[bool, typer.Option("--latex", help="With --table: as LaTeX, with rules of booktabs.")] = False,
    as_json: AsJson = False,
) -> None:
    """Summarize a run: setup, result, reliability, next step.

    Example: tuner show results/quickstart --table front --latex > front.tex
    """
    if table is None:
        from tuner.api.run_report import report_run

        if latex:
            raise InputError("needs a table; add --table front", key="--latex")
        answer(report_run(results), as_json)
        return
    # Rich and pandas are imported where something is printed.
    from tuner.api.frames import json_text
    from tuner.cli.tables import TerminalTable, wide_console

    view = tuner.open_results(results).view(table)
    if as_json or latex:
        print(json_text(view._asdict()) if as_json else view.latex)
    else:
        wide_console().print(TerminalTable.of(view))
