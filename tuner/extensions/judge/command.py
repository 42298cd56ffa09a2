"""The command `tuner judge`."""

from pathlib import Path
from typing import Annotated

import typer

import tuner
from plant.errors import InputError
from tuner.cli.answer import answer, progress
from tuner.cli.app import SOURCE, Airframe, AsJson, Gain, Threads, app, gains_of
from tuner.text.errors import BROKEN


@app.command()
def judge(
    after: Annotated[
        Path,
        typer.Argument(
            help="Parameter file of PX4, ArduPilot, Betaflight or the Crazyflie, or a gains.json.", show_default=False
        ),
    ],
    before: Annotated[Path | None, typer.Option(help="The same of the vehicle's current gains.")] = None,
    airframe: Airframe = None,
    source: Annotated[
        str | None,
        typer.Option("--from", help="Source: px4, ardupilot, betaflight, crazyflie or gains.", autocompletion=SOURCE),
    ] = None,
    gain: Gain = None,
    read_back: Annotated[
        Path | None,
        typer.Option(help="Parameters read back from the vehicle: compare them with the file, and fly nothing."),
    ] = None,
    flights: Annotated[int, typer.Option(help="Number of flights of each file.", min=2)] = 256,
    seed: Annotated[int, typer.Option(help="Root seed of vehicles, air and noise.", min=0)] = 1,
    out: Annotated[Path | None, typer.Option(help="New folder for judge.md, assessment.json and rollback/.")] = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Give a second opinion on gains before arming.

    Exit codes: 0 no objection, 1 worse, do not fly or read back otherwise, 2 bad input, 3 not judged.

    Example: tuner judge new.txt --before present.txt --airframe racer5 --out opinion

    Example: tuner judge new.txt --read-back dump.txt

    Example: tuner judge gains.json --gain roll.kp=12
    """
    if read_back is not None:
        if before is not None or airframe is not None or out is not None:
            raise InputError("cannot be combined with --before, --airframe, --out", key="--read-back")
        compared = tuner.read_back(after, read_back, source=source)
        return answer(compared, as_json, 0 if compared.passed else BROKEN)
    given, present = changed(after, before, gain) if gain else (after, before)
    with progress(as_json) as watcher:
        made = tuner.judge(
            given,
            present,
            airframe=airframe,
            source=source,
            flights=flights,
            seed=seed,
            out=out,
            threads=threads,
            watcher=watcher,
        )
    return answer(made, as_json, made.exit_code)


def changed(after: Path, before: Path | None, gain: list[str]) -> "tuple[tuner.Gains, Path]":
    """Return the changed gains of a gains.json, and the present ones."""
    if after.suffix != ".json":
        raise InputError(
            f"changes gains of a gains.json; edit a copy of {after.name} and give the original with --before",
            key="--gain",
        )
    return tuner.read_gains(after).replace(gains_of(gain)), before or after
