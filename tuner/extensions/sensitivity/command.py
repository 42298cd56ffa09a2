"""The command `tuner sensitivity`."""

from pathlib import Path
from typing import Annotated

import typer

import tuner
from tuner.cli.answer import answer, progress
from tuner.cli.app import AsJson, StudyFile, Threads, app


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
