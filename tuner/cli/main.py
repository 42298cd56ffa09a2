"""The command line: handlers parse, call one library function and print; nothing numerical lives here.

Imports stand inside the handlers because `tuner --help` must not wait for compilers and plotting libraries.
"""

import os
import signal
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from tuner.cli.app import AIRFRAME, LISTING, SOURCE, STUDY, TARGET, app, found_study, law_option, study_option
from tuner.text.errors import guarded

StudyFile = Annotated[
    Path,
    typer.Argument(
        help="Study: a file (TOML), or a name that `tuner list studies` shows.",
        show_default=False,
        callback=found_study,
        autocompletion=STUDY,
    ),
]
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
    reuse: Annotated[
        list[Path] | None,
        typer.Option(help="Results folder whose flights are taken over where they are the same; may be repeated."),
    ] = None,
    dask: Annotated[
        str | None,
        typer.Option(help="Fly on a Dask cluster: local:N processes, or a scheduler such as tcp://host:8786."),
    ] = None,
    backend: Annotated[
        str, typer.Option(help="Who flies: lanes (the processor), cuda (a graphics card) or cuda-float32.")
    ] = "lanes",
    as_json: AsJson = False,
) -> None:
    """Search a study's gains, check the finalists on unseen turbulence, write results and report.

    Exit codes: 0 gains are recommended; 2 bad input; 3 no feasible candidate, so none are; 130 interrupted.

    Example: tuner run quickstart --out results/first --set search.generations=20
    """
    from tuner.cli.commands import run_command

    run_command(study, out, threads, change or [], reuse or [], as_json, dask, backend)


@app.command()
def resume(
    results: Annotated[Path, typer.Argument(help="A results folder.", show_default=False)],
    budget: Annotated[
        int | None, typer.Option(help="Generations in all: more than before extends the search.", min=1)
    ] = None,
    threads: Threads = None,
    dask: Annotated[
        str | None,
        typer.Option(help="Fly on a Dask cluster: local:N processes, or a scheduler such as tcp://host:8786."),
    ] = None,
    here: Annotated[
        bool, typer.Option("--here", help="Compute a run of another machine anew, in this machine's arithmetic.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Go on with a run that was stopped, killed or ran out of disk; it ends with the bits it would have ended with.

    Example: tuner resume results/quickstart --budget 30
    """
    from tuner.cli.resume import resume_command

    resume_command(results, budget, threads, as_json, dask, here)


@app.command()
def verify(
    results: Annotated[Path, typer.Argument(help="A results folder.", show_default=False)],
    sample: Annotated[
        int | None, typer.Option(help="Candidates to fly again, drawn at random; by default all.", min=1)
    ] = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Fly a recorded run again and say whether every bit is the same and every file what was written; exit code 1 if not.

    Example: tuner verify results/quickstart --sample 20
    """
    from tuner.cli.verify import verify_command

    verify_command(results, sample, threads, as_json)


@app.command()
def rejudge(
    results: Annotated[Path, typer.Argument(help="A results folder.", show_default=False)],
    out: Annotated[Path, typer.Option(help="Results folder to write; must not exist.", show_default=False)],
    study: Annotated[Path | None, study_option("Judge by this study; default: that of the run.")] = None,
    change: Annotated[
        list[str] | None,
        typer.Option("--set", help="KEY=VALUE: replace a value of the study, e.g. objective.0.level=0.9."),
    ] = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Judge the candidates of a run by other objectives, risks, limits or pick rules, from the flights already flown.

    Example: tuner rejudge results/quickstart --set objective.0.level=0.9 --out results/cvar90
    """
    from tuner.cli.rejudge import rejudge_command

    rejudge_command(results, out, study, change or [], threads, as_json)


@app.command()
def fly(
    gains: Annotated[Path | None, typer.Argument(help="A gains.json; leave out to fly a law's defaults.")] = None,
    law: Annotated[str | None, law_option("Attitude law to fly with its default gains.")] = None,
    position_law: Annotated[str, law_option("Position law, with --law.")] = "ladrc",
    airframe: Annotated[
        str | None, typer.Option(help="Airframe: a bundled name or a TOML file.", autocompletion=AIRFRAME)
    ] = None,
    study: Annotated[Path | None, study_option("Fly a scenario of this study.")] = None,
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
    study: Annotated[Path | None, study_option("Measure the disturbance in the scenarios of this study.")] = None,
    level: Annotated[
        float, typer.Option(help="Quantile of the measured disturbance rate.", min=0.5, max=0.9999)
    ] = 0.99,
    as_json: AsJson = False,
) -> None:
    """Print what theory guarantees for gains on each axis, against the disturbance rate of the air.

    Example: tuner theory results/quickstart/gains.json --study quickstart
    """
    from tuner.cli.theory import theory_command

    theory_command(gains, study, level, as_json)


@app.command()
def margins(
    gains: Annotated[Path | None, typer.Argument(help="A gains.json; leave out to judge a law's defaults.")] = None,
    law: Annotated[str | None, law_option("Attitude law to judge with its default gains.")] = None,
    position_law: Annotated[str, law_option("Position law, with --law.")] = "ladrc",
    airframe: Annotated[
        str | None, typer.Option(help="Airframe: a bundled name or a TOML file.", autocompletion=AIRFRAME)
    ] = None,
    study: Annotated[Path | None, study_option("Judge by the [[margin]] tables of this study.")] = None,
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

    Example: tuner design quickstart --out designed.json
    """
    from tuner.cli.design import design_command

    design_command(study, out, as_json)


@app.command("list")
def list_(
    what: Annotated[
        str,
        typer.Argument(
            help="airframes, laws, margins, metrics, references, risks, searches, sources, studies, targets or theorems.",
            autocompletion=LISTING,
        ),
    ],
    containing: Annotated[
        str | None, typer.Argument(help="Keep the rows that hold this text, in any case.", metavar="[FILTER]")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List what the tool knows, or what of it holds a text.

    Example: tuner list metrics

    Example: tuner list laws observer
    """
    from tuner.cli.listing import list_command

    list_command(what, containing, as_json)


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
    source: Annotated[
        Path | None, study_option("Copy this study, with its comments; default: a template.", "--from")
    ] = None,
) -> None:
    """Write a commented study file to start from.

    Example: tuner new my_quad --from f450
    """
    from tuner.cli.commands import new_command

    new_command(name, source)


@app.command()
def check(
    file: Annotated[
        Path,
        typer.Argument(
            help="Study, contest, inference, airframe (TOML) or gains.json.",
            show_default=False,
            callback=found_study,
            autocompletion=STUDY,
        ),
    ],
    requirements: Annotated[
        Path | None, study_option("Fly the gains and judge them by the limits of this study.")
    ] = None,
    seeds: Annotated[
        int | None, typer.Option(help="Flights of each scenario; by default the study's held_out.", min=2)
    ] = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Check a file without flying, or judge gains by hard limits: exit code 0 fine, 1 hopeless or broken, 2 bad input.

    Of a study it tells thrust-to-weight, trim in the mean wind, the default's margins and limits that nothing can reach.

    Example: tuner check quickstart

    Example: tuner check results/quickstart/gains.json --requirements quickstart --json
    """
    from tuner.cli.check import check_command

    check_command(file, requirements, seeds, threads, as_json)


@app.command()
def report(results: Annotated[Path, typer.Argument(help="A results folder.", show_default=False)]) -> None:
    """Write report.html and the figures of a results folder again.

    Example: tuner report results/quickstart
    """
    from tuner.cli.commands import report_command

    report_command(results)


@app.command()
def sensitivity(
    study: StudyFile,
    samples: Annotated[
        int, typer.Option(help="Base samples, a power of two; each takes a candidate for every variable and two more.")
    ] = 128,
    out: Annotated[Path | None, typer.Option(help="Write tables and chart into this new folder.")] = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Say which gains decide each objective, alone and together, and how much of it is turbulence.

    Example: tuner sensitivity quickstart --samples 256 --out results/sensitivity
    """
    from tuner.cli.sensitivity import sensitivity_command

    sensitivity_command(study, samples, out, threads, as_json)


@app.command()
def plan(
    study: StudyFile,
    difference: Annotated[
        float, typer.Option(help="Difference from the default that shall be told [%].", min=0.01, max=100.0)
    ] = 5.0,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Fly a few candidates and say what a run will take and how sure its figures will be.

    Example: tuner plan quickstart --difference 2
    """
    from tuner.cli.plan import plan_command

    plan_command(study, difference, threads, as_json)


@app.command()
def compare(
    what: Annotated[
        list[Path], typer.Argument(help="Results folders and gains files, two or more.", metavar="RESULTS|GAINS")
    ],
    study: Annotated[
        Path | None, study_option("Fly the scenarios of this study; default: those of the first results folder.")
    ] = None,
    seeds: Annotated[
        int | None, typer.Option(help="Flights of each scenario; by default the study's held_out.", min=2)
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Write numbers, figures and a page into this new folder.")] = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Fly results and gains files through the same scenarios and compare them with the first, in pairs.

    Example: tuner compare results/quickstart gains.json --seeds 256 --out comparison
    """
    from tuner.cli.compare import compare_command

    compare_command(what, study, seeds, out, threads, as_json)


@app.command()
def show(
    results: Annotated[Path, typer.Argument(help="A results folder, finished or not.", show_default=False)],
    as_json: AsJson = False,
) -> None:
    """Tell in the terminal what a run was asked, what it found, how far to trust it and what to fly.

    Example: tuner show results/quickstart
    """
    from tuner.cli.show import show_command

    show_command(results, as_json)


@app.command()
def export(
    gains: Annotated[Path, typer.Argument(help="A gains.json.", show_default=False)],
    to: Annotated[
        str,
        typer.Option(help="Target: see `tuner list targets`.", show_default=False, autocompletion=TARGET),
    ],
    out: Annotated[Path | None, typer.Option(help="Folder to write. Default: export/TARGET beside the gains.")] = None,
    firmware: Annotated[
        str | None, typer.Option(help="Firmware version, for targets whose names depend on it.")
    ] = None,
    change: Annotated[list[str] | None, typer.Option("--set", help="NAME=VALUE: an option of the target.")] = None,
    previous: Annotated[
        Path | None,
        typer.Option(help="What the vehicle flies at present, for the rollback; default: the target's defaults."),
    ] = None,
    flights: Annotated[int, typer.Option(help="Flights before and after rounding.", min=2)] = 64,
    force: Annotated[
        bool, typer.Option("--force", help="Write gains of a run that found nothing feasible all the same.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Write gains for a target, work out again what rounding does to them, and keep what to go back to.

    Example: tuner export results/quickstart/gains.json --to c99
    """
    from tuner.cli.export import export_command

    export_command(gains, to, out, firmware, change or [], previous, flights, as_json, force)


@app.command("import")
def import_(
    parameters: Annotated[Path, typer.Argument(help="Parameter file of a vehicle.", show_default=False)],
    source: Annotated[
        str,
        typer.Option("--from", help="Source: see `tuner list sources`.", show_default=False, autocompletion=SOURCE),
    ],
    airframe: Annotated[
        str, typer.Option(help="Airframe: a bundled name or a TOML file.", show_default=False, autocompletion=AIRFRAME)
    ],
    out: Annotated[Path, typer.Option(help="The gains.json to write; must not exist.")] = Path("vehicle.json"),
    firmware: Annotated[str | None, typer.Option(help="Firmware version, where names depend on it.")] = None,
    change: Annotated[list[str] | None, typer.Option("--set", help="NAME=VALUE: an option of the source.")] = None,
    as_json: AsJson = False,
) -> None:
    """Read the gains that a vehicle flies already, for `[controller] default = "vehicle.json"` in a study.

    Example: tuner import quad.params --from px4 --airframe iris --out vehicle.json
    """
    from tuner.cli.importing import import_command

    import_command(parameters, source, airframe, out, firmware, change or [], as_json)


@app.command()
def validate(
    file: Annotated[Path, typer.Argument(help="A gains.json.", show_default=False)],
    as_json: AsJson = False,
) -> None:
    """Check schema, units, ranges and hash of a gains.json: exit code 0, or 2 with one line for each problem.

    Example: tuner validate results/quickstart/gains.json
    """
    from tuner.cli.validate import validate_command

    validate_command(file, as_json)


@app.command()
def schema(name: Annotated[str, typer.Argument(help="gains.", show_default=False)]) -> None:
    """Print the JSON Schema (2020-12) of a file that the tool writes.

    Example: tuner schema gains > gains.schema.json
    """
    from tuner.cli.schema import schema_command

    schema_command(name)


@app.command()
def cost(
    gains: Annotated[
        Path | None, typer.Argument(help="A gains.json; leave out for laws at their default gains.")
    ] = None,
    law: Annotated[str | None, law_option("Attitude law; leave out for all.")] = None,
    position_law: Annotated[str, law_option("Position law, with --law or for all.")] = "ladrc",
    measure: Annotated[
        bool, typer.Option("--measure", help="Count now, with arm-none-eabi-gcc and qemu-system-arm.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Print what a control step costs on a Cortex-M4F: instructions, code, state and stack.

    Example: tuner cost --law hybrid
    """
    from tuner.cli.cost import cost_command

    cost_command(gains, law, position_law, measure, as_json)


def main() -> None:
    """Entry point of the console script."""
    # Before and after the command's own work, Ctrl-C ends the process without a word.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(guarded(_invoke))


def _invoke() -> Any:
    # A width of 0, which some programs without a terminal hand on, is none: nothing at all would fit.
    if not os.environ.get("COLUMNS", "1").strip("0"):
        del os.environ["COLUMNS"]
    return app(prog_name="tuner")
