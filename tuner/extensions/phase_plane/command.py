"""The command `tuner phase-plane`."""

from pathlib import Path
from typing import Annotated

import typer

import tuner
from tuner.api import POSITION_LAW
from tuner.cli.answer import progress
from tuner.cli.app import (
    Airframe,
    FlownLaw,
    FlownStudy,
    Gain,
    GivenGains,
    PositionLaw,
    ScenarioNumber,
    Threads,
    app,
)
from tuner.cli.evaluate import gains_or_law, study_of
from tuner.text.sentences import counted, listing

FILE = Path("phase.png")


@app.command("phase-plane")
def phase_plane(
    gains: GivenGains = None,
    law: FlownLaw = None,
    position_law: PositionLaw = POSITION_LAW,
    airframe: Airframe = None,
    gain: Gain = None,
    study: FlownStudy = None,
    scenario: ScenarioNumber = 0,
    seeds: Annotated[int, typer.Option(help="Number of flights; 16 are drawn at most.", min=1)] = 8,
    plot: Annotated[Path, typer.Option(help="File to write: .png, .pdf or .svg.")] = FILE,
    threads: Threads = None,
) -> None:
    """Draw the error of each loop against its rate.

    Example: tuner phase-plane studies/dc_motor.toml --gain angle.kp=2 --plot angle.png

    Example: tuner phase-plane --law hybrid --plot hybrid.svg
    """
    # Here, because every `tuner --help` imports this module.
    from tuner.extensions.phase_plane.trajectories import trajectories

    given = gains_or_law(gains, law, position_law, airframe, gain, "tuner phase-plane --law hybrid")
    with progress(False) as watcher:
        flights = tuner.fly(
            given, study=study_of(gains, study), scenario=scenario, flights=seeds, watcher=watcher, threads=threads
        )
        tuner.phase_plane(flights, plot)
    loops = [each.signal for each in trajectories(flights.recorded)]
    print(f"Phase planes of {listing(loops)}, {counted(seeds, 'flight')} of scenario {flights.scenario}: {plot}")
