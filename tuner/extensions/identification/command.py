"""The command `tuner identify`."""

from pathlib import Path
from typing import Annotated

import typer

import tuner
from plant.errors import InputError
from tuner.cli.answer import answer, progress
from tuner.cli.app import AIRFRAME, AsJson, TextKind, app, study_option
from tuner.text.errors import BROKEN


@app.command()
def identify(
    logs: Annotated[
        list[str] | None,
        TextKind.LOG,
        typer.Argument(
            help="Flight logs of one vehicle; FILE@35:65 for a part [s].", show_default=False, metavar="LOG..."
        ),
    ] = None,
    airframe: Annotated[
        str | None,
        typer.Option(help="Prior: a bundled airframe or a TOML file.", autocompletion=AIRFRAME),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Airframe file to write; with --plan, a folder.")] = None,
    check: Annotated[bool, typer.Option("--check", help="Check the logs only.")] = False,
    mapping: Annotated[Path | None, typer.Option(help="Column mapping of CSV logs (TOML).")] = None,
    mass: Annotated[float, typer.Option(help="Relative standard deviation of the mass.")] = 0.02,
    arm: Annotated[float, typer.Option(help="Relative standard deviation of lengths.")] = 0.02,
    force: Annotated[bool, typer.Option("--force", help="Use logs that failed the checks.")] = False,
    report: Annotated[Path | None, typer.Option(help="Write an HTML page: predictions, residuals, intervals.")] = None,
    update: Annotated[Path | None, typer.Option(help="Refine an earlier result (output of `identify --json`).")] = None,
    changed: Annotated[
        str | None, typer.Option(help="With --update: what changed since: battery, propellers or firmware.")
    ] = None,
    plan: Annotated[
        str | None,
        typer.Option(help="Design an identification flight for this airframe instead.", autocompletion=AIRFRAME),
    ] = None,
    numbers: Annotated[
        str | None,
        typer.Option(help="With --plan: parameters to identify, e.g. lag_up,inertia.x; default: all identifiable."),
    ] = None,
    within: Annotated[str, typer.Option(help="With --plan: target half-width of the 95 % intervals.")] = "10%",
    tilt: Annotated[float, typer.Option(help="With --plan: largest tilt [deg].")] = 20.0,
    rate: Annotated[float, typer.Option(help="With --plan: largest body rate [deg/s].")] = 200.0,
    gains: Annotated[Path | None, typer.Option(help="With --plan: gains.json to fly; default: pid.")] = None,
    study: Annotated[Path | None, study_option("With --plan: study with wind and sensors (first scenario).")] = None,
    to: Annotated[str, typer.Option(help="With --plan: output, csv, ardupilot or betaflight.")] = "csv",
    as_json: AsJson = False,
) -> None:
    """Estimate an airframe with 95 % intervals from flight logs.

    Formats: Crazyflie (SD card), PX4 (ULog), ArduPilot (.bin), Betaflight (decoded to CSV), CSV with a mapping. With --plan it
    designs an identification flight for the target intervals, within limits of tilt, rate and the acceleration of rotors.

    Example: tuner identify log15 --airframe crazyflie-pybullet --out mine.toml --report mine.html
    """
    if plan is not None:
        if logs or check or force or not (airframe is update is changed is mapping is None):
            raise InputError("takes no logs; remove LOG and its options", key="--plan")
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
            changed=changed,
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
