"""Commands towards a vehicle, and of its files: export, schema."""

from pathlib import Path
from typing import Annotated

import typer

import tuner
from tuner.cli.answer import answer, progress
from tuner.cli.app import (
    SCHEMA,
    TARGET,
    AsJson,
    GainsFile,
    TargetChanges,
    app,
    study_option,
    target_options,
)
from tuner.text.errors import BROKEN


@app.command()
def export(
    gains: GainsFile,
    to: Annotated[
        str,
        typer.Option(help="Target: see `tuner list targets`.", show_default=False, autocompletion=TARGET),
    ],
    out: Annotated[Path | None, typer.Option(help="Folder to write. Default: export/TARGET next to the gains.")] = None,
    firmware: Annotated[
        str | None, typer.Option(help="Firmware version, for targets whose names depend on it.")
    ] = None,
    change: TargetChanges = None,
    previous: Annotated[
        Path | None,
        typer.Option(
            help="Parameter file of the vehicle's current gains, for the rollback; default: the target's defaults."
        ),
    ] = None,
    study: Annotated[
        Path | None, study_option("Study of a plant that the gains belong to; default: that of their results folder.")
    ] = None,
    flights: Annotated[int, typer.Option(help="Number of flights before and after rounding.", min=2)] = 64,
    force: Annotated[bool, typer.Option("--force", help="Export infeasible gains for a test bench.")] = False,
    as_json: AsJson = False,
) -> None:
    """Export gains, check rounding effects, save a rollback.

    Example: tuner export results/quickstart/gains.json --to c99
    """
    with progress(as_json) as watcher:
        made = tuner.export(
            gains,
            to,
            out,
            options=target_options(change, firmware),
            previous=previous,
            study=study,
            flights=flights,
            force=force,
            watcher=watcher,
        )
    answer(made, as_json, 0 if made.passed else BROKEN)


@app.command()
def schema(
    name: Annotated[
        str,
        typer.Argument(
            help="A file that is read (study, plant-study, contest-study, trials-study) or written "
            "(gains, summary, contest, ...).",
            show_default=False,
            autocompletion=SCHEMA,
        ),
    ],
) -> None:
    """Print the JSON Schema (2020-12) of a file.

    Example: tuner schema study > study.schema.json

    Example: tuner schema gains > gains.schema.json
    """
    from tuner.documents.registry import schema_of

    print(schema_of(name), end="")
