"""The command `tuner compare-logs`."""

from pathlib import Path
from typing import Annotated

import typer

import tuner
from tuner.cli.answer import answer, progress
from tuner.cli.app import AIRFRAME, AsJson, TextKind, app, study_option
from tuner.text.errors import BROKEN


@app.command("compare-logs")
def compare_logs(
    before: Annotated[
        str,
        TextKind.LOG,
        typer.Argument(help="Log of the first flight; FILE@35:65 for a part [s].", show_default=False),
    ],
    after: Annotated[
        str,
        TextKind.LOG,
        typer.Argument(help="Log of the second, a similar flight in similar wind.", show_default=False),
    ],
    airframe: Annotated[
        str, typer.Option(help="Airframe that flew, roughly: a bundled name or a TOML file.", autocompletion=AIRFRAME)
    ],
    gains: Annotated[Path | None, typer.Option(help="gains.json of the second flight, to predict it.")] = None,
    study: Annotated[Path | None, study_option("Predict it by the first scenario of this study.")] = None,
    mapping: Annotated[Path | None, typer.Option(help="Column mapping of CSV logs (TOML).")] = None,
    as_json: AsJson = False,
) -> None:
    """Compare two flight logs, with intervals and prediction.

    Exit code 1 where the second flight is worse than predicted.

    Example: tuner compare-logs before.bin after.bin --airframe mine.toml --gains gains.json --study mine_study.toml
    """
    with progress(as_json) as watcher:
        result = tuner.compare_logs(
            before, after, airframe=airframe, gains=gains, study=study, mapping=mapping, watcher=watcher
        )
    answer(result, as_json, 0 if result.is_as_predicted else BROKEN)
