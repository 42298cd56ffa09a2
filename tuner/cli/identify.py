"""Commands on flight logs: identify, compare-logs."""

from pathlib import Path
from typing import Annotated

import typer

import tuner
from tuner.cli.answer import answer, progress
from tuner.cli.app import AIRFRAME, AsJson, app, study_option
from tuner.text.errors import BROKEN


@app.command()
def identify(
    logs: Annotated[
        list[str],
        typer.Argument(
            help="Flight logs of one vehicle; FILE@35:65 for a part [s].", show_default=False, metavar="LOG..."
        ),
    ],
    airframe: Annotated[
        str, typer.Option(help="What is known beforehand: a bundled airframe or a TOML file.", autocompletion=AIRFRAME)
    ],
    out: Annotated[Path | None, typer.Option(help="Airframe file to write, NAME.toml.")] = None,
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
    as_json: AsJson = False,
) -> None:
    """Identify a vehicle from flight logs: an airframe file with intervals, and what the data do not tell.

    Reads logs of Crazyflie (SD card), PX4 (ULog), ArduPilot (.bin), Betaflight (decoded to CSV), and CSV with a mapping.

    Example: tuner identify log15 --airframe crazyflie-pybullet --out mine.toml --report mine.html
    """
    if check:
        checked = tuner.check_logs(logs, airframe=airframe, mapping=mapping)
        answer(checked, as_json, 0 if checked.usable else BROKEN)
        return
    with progress(as_json) as watcher:
        found = tuner.identify(
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
    answer(found, as_json)


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
        found = tuner.compare_logs(
            before, after, airframe=airframe, gains=gains, study=study, mapping=mapping, watcher=watcher
        )
    answer(found, as_json, 0 if found.kept else BROKEN)
