"""Command for guarantees of theory: theory."""

from pathlib import Path
from typing import Annotated

import typer

import tuner
from tuner.cli.answer import answer
from tuner.cli.app import AsJson, GainsFile, app, study_option


@app.command()
def theory(
    gains: GainsFile,
    study: Annotated[Path | None, study_option("Measure the disturbance in the scenarios of this study.")] = None,
    level: Annotated[
        float, typer.Option(help="Quantile of the measured disturbance rate.", min=0.5, max=0.9999)
    ] = 0.99,
    as_json: AsJson = False,
) -> None:
    """Compute theoretical guarantees for every axis.

    Example: tuner theory results/quickstart/gains.json --study quickstart
    """
    answer(tuner.theory(gains, study=study, level=level), as_json)
