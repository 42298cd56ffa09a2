"""Commands that read what was found: show, report, compare, sensitivity."""

from pathlib import Path
from typing import Annotated

import typer

import tuner
from tuner.cli.answer import answer, progress
from tuner.cli.app import AsJson, Folder, Seeds, StudyFile, Threads, app, study_option


@app.command()
def report(results: Folder) -> None:
    """Regenerate report.html and figures.

    Example: tuner report results/quickstart
    """
    print(tuner.open_results(results).report())


@app.command()
def sensitivity(
    study: StudyFile,
    samples: Annotated[
        int, typer.Option(help="Base samples, a power of two; each takes a candidate for every variable and two more.")
    ] = 128,
    out: Annotated[Path | None, typer.Option(help="Write tables and chart into this new folder.")] = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Compute Sobol indices of the gains per objective.

    Example: tuner sensitivity quickstart --samples 256 --out results/sensitivity
    """
    with progress(as_json, quiet=True) as watcher:
        result = tuner.sensitivity(study, samples=samples, out=out, watcher=watcher, threads=threads)
    answer(result, as_json)


@app.command()
def compare(
    what: Annotated[
        list[Path], typer.Argument(help="Results folders and gains files, two or more.", metavar="RESULTS|GAINS")
    ],
    study: Annotated[
        Path | None, study_option("Fly the scenarios of this study; default: those of the first results folder.")
    ] = None,
    seeds: Seeds = None,
    out: Annotated[Path | None, typer.Option(help="Write numbers, figures and a page into this new folder.")] = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Compare results or gains with the first, paired, on the same flights.

    Example: tuner compare results/quickstart gains.json --seeds 256 --out comparison
    """
    with progress(as_json) as watcher:
        result = tuner.compare(what, out, study=study, flights=seeds, watcher=watcher, threads=threads)
    answer(result, as_json)


@app.command()
def show(
    results: Annotated[Path, typer.Argument(help="A results folder, finished or not.", show_default=False)],
    as_json: AsJson = False,
) -> None:
    """Summarize a run: setup, result, reliability, next step.

    Example: tuner show results/quickstart
    """
    from tuner.api.run_report import report_run

    answer(report_run(results), as_json)
