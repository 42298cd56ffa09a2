"""The command line: handlers parse, call one library function and print; nothing numerical lives here.

Imports stand inside the handlers because `tuner --help` must not wait for compilers and plotting libraries.
"""

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from tuner.cli.errors import guarded

app = typer.Typer(
    name="tuner",
    help="Tune quadrotor controllers so that their gains hold in turbulence.\n\nExample: tuner run studies/quickstart.toml",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    epilog="Every command has --help with an example. --debug shows the traceback of an error.",
)

StudyFile = Annotated[Path, typer.Argument(help="Study file (TOML).", show_default=False)]
Threads = Annotated[int | None, typer.Option(help="Threads; by default one for each core.", min=1)]
AsJson = Annotated[bool, typer.Option("--json", help="Print figures as JSON and nothing else.")]


@app.command()
def run(
    study: StudyFile,
    out: Annotated[Path | None, typer.Option(help="Results folder; must not exist. Default: results/NAME.")] = None,
    threads: Threads = None,
    change: Annotated[
        list[str] | None,
        typer.Option("--set", help="KEY=VALUE: replace a value of the study, e.g. search.generations=3."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Search a study's gains, check the finalists on unseen turbulence, write results and report.

    Example: tuner run studies/quickstart.toml --out results/first --set search.generations=20
    """
    from tuner.cli.commands import run_command

    run_command(study, out, threads, change or [], as_json)


@app.command()
def fly(
    gains: Annotated[Path | None, typer.Argument(help="A gains.json; leave out to fly a law's defaults.")] = None,
    law: Annotated[str | None, typer.Option(help="Attitude law to fly with its default gains.")] = None,
    position_law: Annotated[str, typer.Option(help="Position law, with --law.")] = "ladrc",
    airframe: Annotated[str | None, typer.Option(help="Airframe: a bundled name or a TOML file.")] = None,
    study: Annotated[Path | None, typer.Option(help="Fly a scenario of this study.")] = None,
    scenario: Annotated[int, typer.Option(help="Which scenario of the study, from 0.", min=0)] = 0,
    seeds: Annotated[int, typer.Option(help="Number of flights, each in its own turbulence.", min=1)] = 64,
    seed: Annotated[int, typer.Option(help="Root seed where no study gives one.", min=0)] = 1,
    plot: Annotated[Path | None, typer.Option(help="Write the responses to this .png, .pdf or .svg.")] = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Fly gains through turbulence and print their metrics and a plot.

    Example: tuner fly --law hybrid --seeds 256 --plot hybrid.png
    """
    from tuner.cli.fly import fly_command

    fly_command(gains, law, position_law, airframe, study, scenario, seeds, seed, plot, threads, as_json)


@app.command()
def theory(
    gains: Annotated[Path, typer.Argument(help="A gains.json.", show_default=False)],
    study: Annotated[Path | None, typer.Option(help="Measure the disturbance in the scenarios of this study.")] = None,
    level: Annotated[
        float, typer.Option(help="Quantile of the measured disturbance rate.", min=0.5, max=0.9999)
    ] = 0.99,
    as_json: AsJson = False,
) -> None:
    """Print what theory guarantees for gains on each axis, against the disturbance rate of the air.

    Example: tuner theory results/quickstart/gains.json --study studies/quickstart.toml
    """
    from tuner.cli.theory import theory_command

    theory_command(gains, study, level, as_json)


@app.command()
def margins(
    gains: Annotated[Path | None, typer.Argument(help="A gains.json; leave out to judge a law's defaults.")] = None,
    law: Annotated[str | None, typer.Option(help="Attitude law to judge with its default gains.")] = None,
    position_law: Annotated[str, typer.Option(help="Position law, with --law.")] = "ladrc",
    airframe: Annotated[str | None, typer.Option(help="Airframe: a bundled name or a TOML file.")] = None,
    study: Annotated[Path | None, typer.Option(help="Judge by the [[margin]] tables of this study.")] = None,
    yaw: Annotated[float, typer.Option(help="Yaw in steady flight [deg].")] = 0.0,
    speed: Annotated[float, typer.Option(help="Ground speed along the heading [m/s].")] = 0.0,
    wind: Annotated[float, typer.Option(help="Steady wind towards east, the x axis of the world [m/s].")] = 0.0,
    attitude_only: Annotated[bool, typer.Option("--attitude-only", help="Leave the loops of x and y open.")] = False,
    certificates: Annotated[bool, typer.Option("--certificates", help="Print what can be proved, too.")] = False,
    out: Annotated[Path | None, typer.Option(help="Write figures and margins.json into this new folder.")] = None,
    as_json: AsJson = False,
) -> None:
    """Print the stability margins of gains, loop by loop; exit code 1 where a limit is broken, 2 for bad input.

    Example: tuner margins results/quickstart/gains.json --out margins
    """
    from tuner.cli.margins import Flown, margins_command

    flown = Flown(yaw, speed, wind, attitude_only)
    margins_command(gains, law, position_law, airframe, study, flown, certificates, out, as_json)


@app.command()
def design(
    study: StudyFile,
    out: Annotated[Path, typer.Option(help="The gains.json to write; must not exist.")] = Path("gains.json"),
    as_json: AsJson = False,
) -> None:
    """Design gains for a study's laws before any search, compare their margins with the defaults', write gains.json.

    Example: tuner design studies/quickstart.toml --out designed.json
    """
    from tuner.cli.design import design_command

    design_command(study, out, as_json)


@app.command("list")
def list_(
    what: Annotated[str, typer.Argument(help="laws, airframes, metrics, references, risks, studies or theorems.")],
    as_json: AsJson = False,
) -> None:
    """List what the tool knows.

    Example: tuner list metrics
    """
    from tuner.cli.listing import list_command

    list_command(what, as_json)


@app.command()
def bench(
    flights: Annotated[int, typer.Option(help="Flights of 10 s on the lanes backend.", min=16)] = 1024,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Measure closed-loop plant steps per second of the backends on this machine.

    Example: tuner bench --json
    """
    from tuner.cli.commands import bench_command

    bench_command(flights, threads, as_json)


@app.command()
def new(
    name: Annotated[str, typer.Argument(help="Name of the study; NAME.toml is written, existing files are kept.")],
) -> None:
    """Write a commented study file to start from.

    Example: tuner new my_quad
    """
    from tuner.cli.commands import new_command

    new_command(name)


@app.command()
def check(study: StudyFile, as_json: AsJson = False) -> None:
    """Read and check a study without flying anything.

    Example: tuner check studies/quickstart.toml
    """
    from tuner.cli.commands import check_command

    check_command(study, as_json)


@app.command()
def report(results: Annotated[Path, typer.Argument(help="A results folder.", show_default=False)]) -> None:
    """Write report.html and the figures of a results folder again.

    Example: tuner report results/quickstart
    """
    from tuner.cli.commands import report_command

    report_command(results)


@app.command()
def version() -> None:
    """Print the version.

    Example: tuner version
    """
    from importlib.metadata import version as installed

    typer.echo(installed("holdfast"))


def main() -> None:
    """Entry point of the console script."""
    sys.exit(guarded(_invoke))


def _invoke() -> Any:
    return app()
