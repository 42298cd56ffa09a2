"""Commands that begin a study: new, list, import, check, plan, design."""

from pathlib import Path
from typing import Annotated, Any

import typer

import tuner
from plant.errors import InputError
from tuner.cli.answer import Messages, answer, progress
from tuner.cli.app import (
    AIRFRAME,
    LISTING,
    SOURCE,
    STUDY,
    AsJson,
    Seeds,
    SourceChanges,
    StudyChanges,
    StudyFile,
    Threads,
    app,
    found_study,
    parse_changes,
    study_option,
    target_options,
)
from tuner.cli.evaluate import answer_validity
from tuner.extension import find
from tuner.text.errors import BROKEN, USER_ERROR


@app.command("list")
def list_(
    what: Annotated[
        str | None,
        typer.Argument(
            metavar="[WHAT]",
            help="airframes, extensions, firmwares, laws, margins, metrics, references, risks, searches, signals, sources, "
            "studies, targets, theorems.",
            autocompletion=LISTING,
        ),
    ] = None,
    containing: Annotated[
        str | None,
        typer.Argument(help="Entry of this name, or rows that contain this text.", metavar="[FILTER]"),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List laws, airframes, metrics and more, optionally filtered.

    Example: tuner list metrics

    Example: tuner list laws pid

    Example: tuner list laws observer
    """
    from tuner.cli.printers.listing import print_listing, print_listings

    if what is None:
        print_listings(as_json)
    else:
        print_listing(what, containing, as_json)


@app.command()
def new(
    name: Annotated[
        str, typer.Argument(help="Name of the study or airframe; NAME.toml is written, existing files are kept.")
    ],
    package: Annotated[
        str | None, typer.Argument(help="After the word extension: folder of a new extension.", show_default=False)
    ] = None,
    kind: Annotated[
        str | None, typer.Option(help="Of an extension: report (command, metric, section; default), law or target.")
    ] = None,
    source: Annotated[
        Path | None, study_option("Copy this study, with its comments; default: a template.", "--from")
    ] = None,
    mass: Annotated[
        float | None, typer.Option(help="Write an airframe: its mass in flight [kg].", show_default=False)
    ] = None,
    wheelbase: Annotated[float | None, typer.Option(help="From a motor to the one opposite [m].")] = None,
    propeller: Annotated[str | None, typer.Option(help="Inches: 10x4.5; of three blades 5.1x4.8x3.")] = None,
    kv: Annotated[float | None, typer.Option(help="Of the motors [rpm/V].")] = None,
    cells: Annotated[int | None, typer.Option(help="Of the battery, in series.")] = None,
    hover: Annotated[float | None, typer.Option(help="Motor command at hover over full command, if measured.")] = None,
    out: Annotated[Path | None, typer.Option(help="The file to write, or the folder for it; default: here.")] = None,
    as_json: AsJson = False,
) -> None:
    """Create a commented study file, or an airframe from a parts list.

    Example: tuner new my_quad --from f450

    Example: tuner new airframe --mass 1.4 --wheelbase 0.45 --propeller 10x4.5 --kv 920 --cells 3

    Example: tuner new extension my_extension
    """
    if package is not None:
        files = find("templates", "template", name)(package, kind)
        _print_written(files, f"Install it with: pip install --no-deps --editable {package}", as_json)
        return
    if out is not None:
        name = str(out if out.suffix == ".toml" else out / name)
    parts = {"mass": mass, "wheelbase": wheelbase, "propeller": propeller, "kv": kv, "cells": cells}
    if hover is not None or any(value is not None for value in parts.values()):
        answer(_estimated(name, source, parts, hover), as_json)
        return
    from tuner.study.template import write_study

    files = write_study(name, source)
    _print_written(files, f"Run it with: tuner run {files[0]}", as_json)


def _print_written(files: list[Path], advice: str, as_json: bool) -> None:
    from tuner.api.frames import json_text

    written = [str(file) for file in files]
    print(json_text({"written": written}) if as_json else f"Wrote {', '.join(written)}. {advice}")


def _estimated(name: str, source: Path | None, parts: dict[str, Any], hover: float | None) -> Any:
    missing = [f"--{key}" for key, value in parts.items() if value is None]
    if missing:
        raise InputError(f"incomplete parts list: add {' '.join(missing)}", key="tuner new")
    if source is not None:
        raise InputError("copies a study, and the other options write an airframe; leave either out", key="--from")
    estimate = find("api", "name of the Python API", "estimate_airframe")
    return estimate(name if name.endswith(".toml") else f"{name}.toml", **parts, hover=hover)


@app.command()
def check(
    file: Annotated[
        Path,
        typer.Argument(
            help="Study, contest, airframe (TOML), gains.json, or a law, metric or reference of your own (Python).",
            show_default=False,
            callback=found_study,
            autocompletion=STUDY,
        ),
    ],
    requirements: Annotated[
        Path | None, study_option("Fly the gains and judge them by the limits of this study.")
    ] = None,
    seeds: Seeds = None,
    change: StudyChanges = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Validate a file, or test gains against hard limits.

    Study: thrust-to-weight ratio, trim in the mean wind, margins of the default gains, limits that neither they nor any of 128
    draws from the ranges satisfy. Law or plant of your own: every rule of its contract that it breaks, with the line.
    Exit codes: 0 valid or satisfied, 1 a limit is violated or cannot be met, 2 bad input.

    Example: tuner check quickstart

    Example: tuner check my_law.py

    Example: tuner check results/quickstart/gains.json --requirements quickstart --json
    """
    if requirements is not None:
        with progress(as_json) as watcher:
            judged = tuner.check_requirements(file, requirements, flights=seeds, watcher=watcher, threads=threads)
        answer(judged, as_json, BROKEN if judged.verdict == "fail" else 0)
        return
    if seeds is not None:
        raise InputError("needs --requirements", key="--seeds")
    result = tuner.check(file, changes=parse_changes(change), watcher=Messages())
    if result.kind == "gains":
        answer_validity(result, as_json)
        if not as_json:
            print(f"Judge it by the limits of a study: tuner check {file} --requirements STUDY")
        return
    wrong = USER_ERROR if "breaches" in result.content else BROKEN
    answer(result, as_json, wrong if result.hopeless else 0)


@app.command()
def plan(
    study: StudyFile,
    difference: Annotated[
        float, typer.Option(help="Difference from the default to detect [%].", min=0.01, max=100.0)
    ] = 5.0,
    change: StudyChanges = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Estimate run time and precision from pilot flights.

    Example: tuner plan quickstart --difference 2
    """
    with progress(as_json) as watcher:
        result = tuner.plan(
            tuner.load_study(study, parse_changes(change)), difference=difference, watcher=watcher, threads=threads
        )
    answer(result, as_json)


@app.command()
def design(
    study: StudyFile,
    out: Annotated[Path, typer.Option(help="The gains.json to write; must not exist.")] = Path("gains.json"),
    method: Annotated[
        str, typer.Option(help="Design rule of a plant: simc, lambda, amigo, ...", show_default=False)
    ] = "",
    time: Annotated[float | None, typer.Option(help="Closed-loop time of a rule [s].", show_default=False)] = None,
    as_json: AsJson = False,
) -> None:
    """Compute gains from loop requirements or by a rule, without a search.

    The exit code is 1 if no loop has a design; the file then has the default gains.

    Example: tuner design quickstart --out designed.json
    """
    made = tuner.design(study, out, method=method, time=time, watcher=Messages())
    answer(made, as_json, 0 if made.has_success else BROKEN)


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
    change: SourceChanges = None,
    as_json: AsJson = False,
) -> None:
    """Import a vehicle's current gains as a study's default.

    Name the file in the study: `[controller] default = "vehicle.json"`.

    Example: tuner import quad.params --from px4 --airframe iris --out vehicle.json
    """
    answer(tuner.import_gains(parameters, source, airframe, out, options=target_options(change, firmware)), as_json)
