"""Commands on flight logs: identify, compare-logs."""

from pathlib import Path
from typing import Annotated

import typer

import tuner
from plant.errors import InputError
from tuner.cli.answer import answer, progress
from tuner.cli.app import AIRFRAME, AsJson, app, study_option
from tuner.text.errors import BROKEN


@app.command()
def identify(
    logs: Annotated[
        list[str] | None,
        typer.Argument(
            help="Flight logs of one vehicle; FILE@35:65 for a part [s].", show_default=False, metavar="LOG..."
        ),
    ] = None,
    airframe: Annotated[
        str | None,
        typer.Option(help="What is known beforehand: a bundled airframe or a TOML file.", autocompletion=AIRFRAME),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Airframe file to write, NAME.toml; of a plan: folder for what flies it.")
    ] = None,
    check: Annotated[bool, typer.Option("--check", help="Only say what is wrong with the logs.")] = False,
    mapping: Annotated[Path | None, typer.Option(help="What the columns of CSV logs are (TOML).")] = None,
    mass: Annotated[float, typer.Option(help="Standard deviation of the airframe's mass, relative.")] = 0.02,
    arm: Annotated[float, typer.Option(help="Standard deviation of its lengths, relative.")] = 0.02,
    force: Annotated[bool, typer.Option("--force", help="Use logs that a check calls useless all the same.")] = False,
    report: Annotated[
        Path | None, typer.Option(help="Page to write, NAME.html: predictions, residuals, intervals.")
    ] = None,
    update: Annotated[
        Path | None, typer.Option(help="What `identify --json` printed of earlier logs: these narrow it further.")
    ] = None,
    plan: Annotated[
        str | None,
        typer.Option(help="Instead of reading logs, plan the flight: of this airframe.", autocompletion=AIRFRAME),
    ] = None,
    numbers: Annotated[
        str | None,
        typer.Option(help="Of a plan: what is to be known, lag_up,inertia.x; by default all that a flight tells."),
    ] = None,
    within: Annotated[str, typer.Option(help="Of a plan: half-width of the 95 % intervals, of the number.")] = "10%",
    tilt: Annotated[float, typer.Option(help="Of a plan: largest tilt [deg].")] = 20.0,
    rate: Annotated[float, typer.Option(help="Of a plan: largest body rate [deg/s].")] = 200.0,
    gains: Annotated[
        Path | None, typer.Option(help="Of a plan: gains.json that flies; by default pid for the airframe.")
    ] = None,
    study: Annotated[Path | None, study_option("Of a plan: air and sensors of its first scenario.")] = None,
    to: Annotated[str, typer.Option(help="Of a plan: what flies it: csv, ardupilot or betaflight.")] = "csv",
    as_json: AsJson = False,
) -> None:
    """Identify a vehicle from flight logs: an airframe file with intervals, and what the data do not tell.

    Reads logs of Crazyflie (SD card), PX4 (ULog), ArduPilot (.bin), Betaflight (decoded to CSV), and CSV with a mapping. With
    --plan it tells which flight to make first, so that intervals become as narrow as asked within limits of tilt and rate.

    Example: tuner identify log15 --airframe crazyflie-pybullet --out mine.toml --report mine.html
    """
    if plan is not None:
        if logs or check or force or not (airframe is update is mapping is None):
            raise InputError("a plan is made before there are logs; leave out what belongs to them", key="--plan")
        with progress(as_json) as watcher:
            planned = tuner.plan_flight(
                plan,
                numbers=names_of(numbers),
                within=share_of(within),
                tilt_deg=tilt,
                rate_deg=rate,
                mass=mass,
                arm=arm,
                gains=gains,
                study=study,
                to=to,
                out=out,
                report=report,
                watcher=watcher,
            )
        answer(planned, as_json)
        return
    if not (numbers is gains is study is None):
        raise InputError("--numbers, --gains and --study belong to a plan; give --plan AIRFRAME, or leave them out")
    if not logs or airframe is None:
        raise InputError("give a log and --airframe, or --plan AIRFRAME for the flight to make first")
    if check:
        checked = tuner.check_logs(logs, airframe=airframe, mapping=mapping)
        answer(checked, as_json, 0 if checked.usable else BROKEN)
        return
    with progress(as_json) as watcher:
        result = tuner.identify(
            logs,
            airframe=airframe,
            out=out,
            mapping=mapping,
            mass=mass,
            arm=arm,
            force=force,
            report=report,
            update=update,
            watcher=watcher,
        )
    answer(result, as_json)


def names_of(given: str | None) -> list[str]:
    """Return the names in a list with commas."""
    return [name.strip() for name in (given or "").split(",") if name.strip()]


def share_of(given: str) -> float:
    """Return a share that is given as 0.05 or as 5%; InputError where it is neither."""
    text = given.strip()
    try:
        return float(text.removesuffix("%")) * (0.01 if text.endswith("%") else 1.0)
    except ValueError:
        raise InputError(f"given '{given}'; give a share, 5% or 0.05", key="--within") from None


@app.command("compare-logs")
def compare_logs(
    before: Annotated[
        str, typer.Argument(help="Log of the first flight; FILE@35:65 for a part [s].", show_default=False)
    ],
    after: Annotated[str, typer.Argument(help="Log of the second, of a like flight in like air.", show_default=False)],
    airframe: Annotated[
        str, typer.Option(help="About what flew: a bundled airframe or a TOML file.", autocompletion=AIRFRAME)
    ],
    gains: Annotated[Path | None, typer.Option(help="gains.json of the second flight, to predict it.")] = None,
    study: Annotated[Path | None, study_option("Predict it by the first scenario of this study.")] = None,
    mapping: Annotated[Path | None, typer.Option(help="What the columns of CSV logs are (TOML).")] = None,
    as_json: AsJson = False,
) -> None:
    """Compare two flight logs: what is less and what is more, with intervals, and whether it was predicted.

    Exit code 1 where the second flight is above its prediction.

    Example: tuner compare-logs before.bin after.bin --airframe mine.toml --gains gains.json --study mine_study.toml
    """
    with progress(as_json) as watcher:
        result = tuner.compare_logs(
            before, after, airframe=airframe, gains=gains, study=study, mapping=mapping, watcher=watcher
        )
    answer(result, as_json, 0 if result.is_as_predicted else BROKEN)
