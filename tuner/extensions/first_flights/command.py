"""Commands before the first flight: confirm, approach."""

from pathlib import Path
from typing import Annotated

import typer

import tuner
from tuner.cli.answer import answer, progress
from tuner.cli.app import FIRMWARE, TARGET, AsJson, TargetChanges, app, study_option, target_options
from tuner.text.errors import BROKEN


@app.command()
def confirm(
    results: Annotated[Path, typer.Argument(help="Folder of a tuning run.", show_default=False)],
    firmware: Annotated[
        str,
        typer.Option(help="Firmware: see `tuner list firmwares`.", show_default=False, autocompletion=FIRMWARE),
    ],
    binary: Annotated[
        Path, typer.Option(help="The firmware's program, module or sources, as listed there.", show_default=False)
    ],
    finalists: Annotated[int, typer.Option(help="Points of the front that fly.", min=1)] = 8,
    flights: Annotated[int, typer.Option(help="Flights of each scenario and finalist.", min=2)] = 16,
    out: Annotated[Path | None, typer.Option(help="New folder for confirm.json and confirm.md.")] = None,
    threads: Annotated[int, typer.Option(help="Boards that fly at once.", min=1)] = 1,
    as_json: AsJson = False,
) -> None:
    """Fly finalists in real firmware on the simulated plant.

    Example: tuner confirm results/betaflight --firmware betaflight --binary betaflight_SITL
    """
    with progress(as_json) as watcher:
        made = tuner.confirm(
            results, firmware, binary, finalists=finalists, flights=flights, out=out, threads=threads, watcher=watcher
        )
    answer(made, as_json)


@app.command()
def approach(
    present: Annotated[Path, typer.Argument(help="A gains.json: the current gains.", show_default=False)],
    tuned: Annotated[Path, typer.Argument(help="A gains.json: the tuned gains.", show_default=False)],
    steps: Annotated[
        int | None,
        typer.Option(help="Steps; by default so many that no gain changes by more than half in one.", min=1, max=32),
    ] = None,
    step: Annotated[
        float | None,
        typer.Option(
            help="Largest change of a gain in a step, in place of --steps: 0.25 for 25 %; PX4 advises 20 to 30 %."
        ),
    ] = None,
    study: Annotated[Path | None, study_option("Fly the first scenario of this study.")] = None,
    flights: Annotated[int, typer.Option(help="Flights of every step.", min=2)] = 64,
    to: Annotated[
        str | None, typer.Option(help="Export every step to this target.", show_default=False, autocompletion=TARGET)
    ] = None,
    out: Annotated[Path | None, typer.Option(help="New folder for approach.json, gains and exports.")] = None,
    firmware: Annotated[
        str | None, typer.Option(help="Firmware version, for targets whose names depend on it.")
    ] = None,
    change: TargetChanges = None,
    previous: Annotated[
        Path | None, typer.Option(help="Parameter file of the vehicle's current gains, for the rollback.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Plan first flights in steps from current to tuned gains.

    Exit code 1 where a margin limit is violated on the way.

    Example: tuner approach present.json results/f450/gains.json --to px4 --out first_flights
    """
    with progress(as_json) as watcher:
        made = tuner.approach(
            present,
            tuned,
            steps=steps,
            step=step,
            study=study,
            flights=flights,
            to=to,
            options=target_options(change, firmware),
            previous=previous,
            out=out,
            watcher=watcher,
        )
    answer(made, as_json, 0 if made.passed else BROKEN)
