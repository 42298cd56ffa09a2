"""Command for small probabilities: tail."""

from pathlib import Path
from typing import Annotated

import typer

import tuner
from tuner.cli.answer import answer, progress
from tuner.cli.app import AsJson, Threads, app, study_option
from tuner.experiments.options import DASK


@app.command()
def tail(
    gains: Annotated[
        list[Path],
        typer.Argument(help="Gains files, results folders, or studies for their default.", metavar="GAINS"),
    ],
    event: Annotated[
        list[str] | None,
        typer.Option(
            "--event",
            help='METRIC > NUMBER, such as "peak.position > 3", or failure; repeatable.',
            show_default="failure",
        ),
    ] = None,
    to: Annotated[float, typer.Option(help="Probability down to which is looked.")] = 1e-6,
    width: Annotated[float, typer.Option(help="Width of the 95 % interval, over the probability.")] = 0.5,
    most: Annotated[int, typer.Option(help="Flights of each event at most.", min=1)] = 1_000_000,
    study: Annotated[Path | None, study_option("Fly a scenario of this study.")] = None,
    scenario: Annotated[int, typer.Option(help="Which scenario of the study, from 0.", min=0)] = 0,
    seed: Annotated[int, typer.Option(help="Root seed where no study gives one.", min=0)] = 1,
    worst: Annotated[
        str | None, typer.Option(help="Seek the worst of this part alone, such as vehicle or air.", show_default="all")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Write numbers and flights into this folder; the same command goes on with it.")
    ] = None,
    threads: Threads = None,
    dask: Annotated[str | None, typer.Option(help=DASK.help)] = None,
    as_json: AsJson = False,
) -> None:
    """Estimate small probabilities of lost flights and exceeded limits.

    Example: tuner tail results/quickstart quickstart --study quickstart --event "peak.position > 3" --to 1e-4

    Example: tuner tail results/motor/gains.json --code motor.py --event failure --out tail
    """
    with progress(as_json) as watcher:
        result = tuner.tail(
            list(gains),
            event or ["failure"],
            to=to,
            width=width,
            most=most,
            study=study,
            scenario=scenario,
            seed=seed,
            worst=worst,
            out=out,
            watcher=watcher,
            threads=threads,
            dask=dask,
        )
    answer(result, as_json)
