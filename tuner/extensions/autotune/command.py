"""The command from logs to tuned parameters: autotune."""

from pathlib import Path
from typing import Annotated

import typer

import tuner
from tuner.cli.answer import answer, progress
from tuner.cli.app import AIRFRAME, SOURCE, AsJson, TextKind, Threads, app
from tuner.text.errors import BROKEN


@app.command()
def autotune(
    logs: Annotated[
        list[str],
        TextKind.LOG,
        typer.Argument(
            help="Flight logs of one vehicle; FILE@35:65 for a part [s].", metavar="LOG...", show_default=False
        ),
    ],
    vehicle: Annotated[Path, typer.Option(help="Parameter file of what the vehicle flies.", show_default=False)],
    airframe: Annotated[
        str,
        typer.Option(
            help="Prior: a bundled airframe or a TOML file; weigh the vehicle.",
            show_default=False,
            autocompletion=AIRFRAME,
        ),
    ],
    out: Annotated[Path, typer.Option(help="Folder; the same command goes on with it.")] = Path("autotune"),
    source: Annotated[
        str | None,
        typer.Option("--from", help="Firmware: px4, ardupilot, betaflight or crazyflie.", autocompletion=SOURCE),
    ] = None,
    mapping: Annotated[Path | None, typer.Option(help="Column mapping of CSV logs (TOML).")] = None,
    binary: Annotated[Path | None, typer.Option(help="Program of the firmware, to fly finalists in it.")] = None,
    restart: Annotated[
        str | None,
        typer.Option(help="Stage to do again with all after it, for instance search; edits in its files are lost."),
    ] = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Tune a vehicle from flight logs and its parameter file.

    Identification, study over what the log leaves open, search, export with a rollback, second opinion, first flights. Files may
    be edited between stages; an input that changed after a stage had read it is refused and named.
    Exit codes: 0 all stages done, 1 the log identifies too little, nothing is feasible or the opinion objects, 2 bad input.

    Example: tuner autotune log15@55:90 --vehicle present.yaml --airframe crazyflie-pybullet --out tuned
    """
    with progress(as_json) as watcher:
        made = tuner.autotune(
            logs,
            vehicle,
            out,
            airframe=airframe,
            source=source,
            mapping=mapping,
            binary=binary,
            restart=restart,
            threads=threads,
            watcher=watcher,
        )
    answer(made, as_json, 0 if made.passed else BROKEN)
