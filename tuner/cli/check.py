"""`tuner check`: a file of any kind without flying, or gains against the hard limits of a study; exit code 1 if broken."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import typer

from plant.airframes import load
from plant.errors import InputError
from tuner.cli.display import digits
from tuner.cli.tables import Table, wide_console
from tuner.cli.terminal import Console
from tuner.study import load_study
from tuner.study.kinds import study_kind
from tuner.study.reading import parse_toml
from tuner.text.errors import BROKEN
from tuner.text.units import in_shown_units

Row = dict[str, Any]
SIGNS = {"most": "<=", "least": ">="}
STYLES = {"fail": "bold red", "not certain": "yellow", "target missed": "yellow"}


def check_command(file: Path, requirements: Path | None, seeds: int | None, threads: int | None, as_json: bool) -> None:
    """Judge a gains file where requirements are given, else say what a file holds; exit code 1 where it is hopeless."""
    if requirements is not None:
        judge_command(file, requirements, seeds, threads, as_json)
        return
    if seeds is not None:
        raise InputError("nothing is flown without --requirements; leave it out, or add --requirements", key="--seeds")
    KINDS[kind_of(file)](file, as_json)


def kind_of(file: Path) -> str:
    """Return what kind of file this is, by its content: a key of `KINDS`. InputError where it cannot be read."""
    if file.is_dir():
        raise InputError(
            "this is a folder; `tuner show` tells a results folder, `tuner verify` flies it again", file=file
        )
    if file.suffix == ".json":
        return "gains"
    table = parse_toml(file)
    if AIRFRAME_KEYS & set(table) and not {"scenario", "objective"} & set(table):
        return "airframe"
    return study_kind(file).name


def describe_study(file: Path, as_json: bool) -> None:
    """Say what a study would fly and what is known of it without flying."""
    from tuner.cli.check_study import show_study
    from tuner.cli.margins import announce_compilation
    from tuner.experiments.tuning.preview import is_hopeless, study_preview

    study = load_study(file)
    if study.table.margin:
        announce_compilation()
    figures = study_preview(study)
    if as_json:
        print(json.dumps(figures, indent=2, allow_nan=False))
    else:
        show_study(figures, wide_console())
    if is_hopeless(figures):
        raise typer.Exit(BROKEN)


def describe_several(file: Path, as_json: bool) -> None:
    """Say what a contest or an inference would fly."""
    from tuner.experiments.planning.preview import preview
    from tuner.study.kinds import load_any

    print_figures(preview(load_any(file)), as_json)


def describe_airframe(file: Path, as_json: bool) -> None:
    """Say what a vehicle has to fly with; what is wrong with its file is an error that names the key."""
    from plant.airframes.derived import quantities

    airframe = load(file)
    known = {name: {"value": entry.value, "unit": entry.unit} for name, entry in quantities(airframe.vehicle).items()}
    figures = {
        "kind": "airframe", "name": airframe.name, "title": airframe.title, "frame": airframe.frame,
        "mass": {"value": airframe.vehicle.mass, "unit": "kg"}, **known,
    }  # fmt: skip
    print_figures(figures, as_json)


def describe_gains(file: Path, as_json: bool) -> None:
    """Say whether a gains file is whole and as it was written, as `tuner validate` does."""
    from tuner.cli.validate import validate_command

    validate_command(file, as_json)
    if not as_json:
        print(f"Judge it by the limits of a study: tuner check {file} --requirements STUDY")


KINDS: dict[str, Callable[[Path, bool], None]] = {
    "tuning": describe_study,
    "airframe": describe_airframe,
    "gains": describe_gains,
    "contest": describe_several,
    "inference": describe_several,
}
"""How each kind of file is checked."""
# Keys that every airframe has at its top and no study.
AIRFRAME_KEYS = {"frame", "spin", "mass", "inertia"}


def print_figures(figures: Row, as_json: bool) -> None:
    """Print figures, a line each."""
    if as_json:
        print(json.dumps(figures, indent=2))
        return
    table = Table(box=None, show_header=False)
    table.add_column("", no_wrap=True)
    table.add_column("")
    for key, value in figures.items():
        table.add_row(key, shown(value))
    wide_console().print(table)


def shown(value: Any) -> str:
    """Return a figure as text: a list with commas, a number with its unit."""
    if isinstance(value, dict):
        unit = "" if value["unit"] == "1" else f" {value['unit']}"
        return f"{value['value']:.4g}{unit}"
    return ", ".join(value) if isinstance(value, list) else str(value)


def judge_command(gains: Path, requirements: Path, seeds: int | None, threads: int | None, as_json: bool) -> None:
    """Fly and judge gains; exit code 1 where a limit is broken."""
    from tuner.analysis.judging.judge import check_batches, controller_to_judge, judge_gains, judgement_document
    from tuner.cli.display import TerminalWatcher
    from tuner.experiments.tuning.problem import problem_of, warm_up
    from tuner.study.kinds import load_tuning

    study = load_tuning(requirements, "tuner check --requirements")
    controller = controller_to_judge(gains, study)
    problem, batches = problem_of(study, threads, None), check_batches(study, seeds)
    if as_json:
        rows = judge_gains(controller, study, problem, batches)
    else:
        with TerminalWatcher(Console()) as bar:
            warm_up(problem, study, bar)
            bar.on_stage("Judging", sum(batch.count for batch in batches))
            rows = judge_gains(controller, study, problem, batches, bar.on_flights_done)
    document = judgement_document(gains, study, rows, batches)
    if as_json:
        print(json.dumps(document, indent=2, allow_nan=False))
    else:
        show(document, Console())
    if document["verdict"] == "fail":
        raise typer.Exit(BROKEN)


def show(document: Row, console: Console) -> None:
    """Print the table and the verdict."""
    table = Table(f"{document['flights']:,} flights of a stream of their own, 95 % intervals", keys=1)
    table.add_column("", no_wrap=True)
    for name in ("limit", "value", "95 % interval", "unit", "verdict"):
        left = name in ("unit", "verdict")
        table.add_column(name, justify="left" if left else "right", no_wrap=True)
    for row in map(in_shown_units, document["rows"]):
        table.add_row(*cells(row), style=STYLES.get(row["verdict"]))
    console.print(table)
    console.print(said(document), highlight=False)


def cells(row: Row) -> list[str]:
    """Return the texts of one row."""
    limit = "" if row["limit"] is None else f"{SIGNS[row['sense']]} {row['limit']:g}"
    unit = "" if row["unit"] == "1" else row["unit"]
    if row["low"] is None:
        value = "unbounded" if row["value"] is None else f"{row['value']:.4g}"
        return [row["label"], limit, value, "", unit, row["verdict"]]
    width = row["high"] - row["low"] or row["value"]
    ends = f"{digits(row['low'], width)} to {digits(row['high'], width)}"
    return [row["label"], limit, digits(row["value"], width), ends, unit, row["verdict"]]


def said(document: Row) -> str:
    """Return the verdict in a sentence, with the names of what decides it."""
    named = {
        verdict: ", ".join(row["label"] for row in document["rows"] if row["verdict"] == verdict)
        for verdict in ("fail", "not certain")
    }
    if document["verdict"] == "fail":
        return f"FAIL: broken by {named['fail']}."
    if document["verdict"] == "not certain":
        return (
            f"PASS on these flights, but not certain: the interval of {named['not certain']} crosses the limit; more --seeds "
            "narrow it, and a limit of 0 lost flights cannot be shown by any number of them."
        )
    return "PASS: every limit is kept."
