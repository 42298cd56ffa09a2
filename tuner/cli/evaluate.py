"""Commands that evaluate gains: fly, margins, validate."""

import sys
from math import radians
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import tuner
from plant.errors import InputError
from tuner.api import AIRFRAME, POSITION_LAW
from tuner.cli.answer import Messages, answer, progress
from tuner.cli.app import (
    Airframe,
    AsJson,
    FlownLaw,
    FlownStudy,
    Gain,
    GainsFile,
    GivenGains,
    PositionLaw,
    ScenarioNumber,
    Threads,
    app,
    gains_of,
    law_option,
    study_option,
)
from tuner.study.files import named_study
from tuner.text.errors import BROKEN, USER_ERROR

if TYPE_CHECKING:
    from tuner.api.checking import Checked


@app.command()
def fly(
    gains: GivenGains = None,
    law: FlownLaw = None,
    position_law: PositionLaw = POSITION_LAW,
    airframe: Airframe = None,
    gain: Gain = None,
    study: FlownStudy = None,
    scenario: ScenarioNumber = 0,
    seeds: Annotated[int, typer.Option(help="Number of flights, each in its own turbulence.", min=1)] = 64,
    seed: Annotated[
        int | None, typer.Option(help="Root seed if no study gives one; default: 1.", min=0, show_default=False)
    ] = None,
    flight: Annotated[
        str | None,
        typer.Option(help="Fly one flight only, STREAM-INDEX, e.g. held-out-4679, or FOLDER/point-N of a tail."),
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Write the responses to this .png, .pdf or .svg.")] = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Simulate gains in turbulence; print metrics and a plot.

    Example: tuner fly --law hybrid --seeds 256 --plot hybrid.png

    Example: tuner fly results/motor/gains.json --code motor.py --gain kp=12

    Example: tuner fly results/quickstart/gains.json --study quickstart --flight held-out-4679 --plot lost.png

    Example: tuner fly results/quickstart/gains.json --study quickstart --flight tail/point-1 --plot point.png
    """
    given = gains_or_law(gains, law, position_law, airframe, gain, "tuner fly --law hybrid")
    with progress(as_json) as watcher:
        flown = tuner.fly(
            given,
            study=study_of(gains, study),
            scenario=scenario,
            flights=seeds,
            seed=seed,
            flight=flight,
            watcher=watcher,
            threads=threads,
        )
    answer(flown, as_json)
    if plot is not None:
        flown.write_figure(plot)


@app.command()
def margins(
    gains: GivenGains = None,
    law: Annotated[str | None, law_option("Attitude law to judge with its default gains.")] = None,
    position_law: PositionLaw = POSITION_LAW,
    airframe: Airframe = None,
    gain: Gain = None,
    study: Annotated[Path | None, study_option("Judge by the [[margin]] tables of this study.")] = None,
    yaw: Annotated[float, typer.Option(help="Yaw in steady flight [deg].")] = 0.0,
    speed: Annotated[float, typer.Option(help="Ground speed along the heading [m/s].")] = 0.0,
    wind: Annotated[float, typer.Option(help="Steady wind towards east, the x axis of the world [m/s].")] = 0.0,
    attitude_only: Annotated[bool, typer.Option("--attitude-only", help="Leave the loops of x and y open.")] = False,
    certificates: Annotated[bool, typer.Option("--certificates", help="Print certificates too.")] = False,
    out: Annotated[Path | None, typer.Option(help="Write figures and margins.json into this new folder.")] = None,
    as_json: AsJson = False,
) -> None:
    """Compute the stability margins of every loop.

    Exit codes: 0 limits satisfied, 1 a limit is violated, 2 bad input.

    Example: tuner margins results/quickstart/gains.json --out margins

    Example: tuner margins studies/dc_motor.toml --gain angle.kp=12
    """
    given = gains_or_law(gains, law, position_law, airframe, gain, "tuner margins --law hybrid")
    result = tuner.margins(
        given,
        study=study_of(gains, study),
        yaw=radians(yaw),
        speed=speed,
        wind=wind,
        hold_position=not attitude_only,
        certificates=certificates,
        out=out,
        watcher=Messages(),
    )
    answer(result, as_json, 0 if result.passed else BROKEN)


@app.command()
def validate(file: GainsFile, as_json: AsJson = False) -> None:
    """Check schema, units, ranges and hash of a gains.json.

    Exit codes: 0 valid, 2 with a line for each problem.

    Example: tuner validate results/quickstart/gains.json
    """
    answer_validity(tuner.validate(file), as_json)


def answer_validity(result: "Checked", as_json: bool) -> None:
    """Print whether a gains file is valid: problems on standard error, a line each."""
    if as_json or not result.hopeless:
        answer(result, as_json)
    else:
        for problem in result.problems:
            print(f"Error: {problem}", file=sys.stderr)
    if result.hopeless:
        raise typer.Exit(USER_ERROR)


def gains_or_law(
    gains: Path | None, law: str | None, position_law: str, airframe: str | None, change: list[str] | None, example: str
) -> "tuner.Gains":
    """Return the gains of a file, or a law's defaults, with changes; InputError unless one of the two is given."""
    if gains is not None and law is None:
        given = tuner.read_gains(gains, airframe)
    elif gains is None and law is not None:
        given = tuner.default_gains(law, position_law, airframe or AIRFRAME)
    else:
        raise InputError(f"give either a gains.json, a study or --law NAME, for instance: {example}")
    return given.replace(gains_of(change)) if change else given


def study_of(gains: Path | None, study: Path | None) -> Path | None:
    """Return the given study, by default the one in place of gains."""
    return named_study(gains) if study is None and gains is not None else study
