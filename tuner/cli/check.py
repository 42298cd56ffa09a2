"""`tuner check`: a study file without flying anything, or gains against the hard limits of a study; exit code 1 if broken."""

import json
from pathlib import Path
from typing import Any

import typer
from rich.box import SIMPLE
from rich.table import Table

from plant.errors import InputError
from tuner.cli.display import digits
from tuner.cli.errors import BROKEN
from tuner.cli.terminal import Console
from tuner.contest import is_contest
from tuner.inference import is_inference
from tuner.study import load_study

Row = dict[str, Any]
SIGNS = {"most": "<=", "least": ">="}
STYLES = {"fail": "bold red", "not certain": "yellow", "target missed": "yellow"}


def check_command(file: Path, requirements: Path | None, seeds: int | None, threads: int | None, as_json: bool) -> None:
    """Judge a gains file where requirements are given, else say what a study would fly."""
    if requirements is not None:
        judge_command(file, requirements, seeds, threads, as_json)
        return
    if file.suffix == ".json":
        raise InputError("gains are judged by requirements; add --requirements STUDY, a study file", file=file)
    if seeds is not None:
        raise InputError("a study is checked without flying; leave it out, or add --requirements", key="--seeds")
    describe_command(file, as_json)


def describe_command(study: Path, as_json: bool) -> None:
    """Say what a study, a contest or an inference would fly, or what is wrong with it."""
    if is_inference(study):
        from tuner.cli.inference import check_inference

        figures = check_inference(study)
    elif is_contest(study):
        from tuner.cli.contest import check_contest

        figures = check_contest(study)
    else:
        figures = check_study(study)
    if as_json:
        print(json.dumps(figures, indent=2))
        return
    for key, value in figures.items():
        print(f"{key:18} {', '.join(value) if isinstance(value, list) else value}")


def check_study(study: Path) -> Row:
    """Return what a study would fly; InputError where it is wrong."""
    asked = load_study(study)
    flights = asked.search.generations * asked.search.population * sum(entry.search for entry in asked.scenarios)
    return {
        "title": asked.title,
        "variables": len(asked.space.variables),
        "objectives": [objective.label for objective in asked.objectives],
        "constraints": [constraint.objective.label for constraint in asked.constraints],
        "requirements": [requirement.label for requirement in asked.requirements],
        "search_flights": flights,
        "digest": asked.digest(),
    }


def judge_command(gains: Path, requirements: Path, seeds: int | None, threads: int | None, as_json: bool) -> None:
    """Fly and judge gains; exit code 1 where a limit is broken."""
    from tuner.cli.flights_bar import FlightsBar
    from tuner.cli.tuning_study import tuning_study
    from tuner.judging.judge import check_fleets, controller_to_judge, judge_gains, judgement_document
    from tuner.run import problem_of, warm_up

    study = tuning_study(requirements, "tuner check --requirements")
    controller = controller_to_judge(gains, study)
    problem, fleets = problem_of(study, threads, None), check_fleets(study, seeds)
    if as_json:
        rows = judge_gains(controller, study, problem, fleets)
    else:
        with FlightsBar(Console()) as bar:
            warm_up(problem, study, bar)
            bar.flying("Judging", sum(fleet.count for fleet in fleets))
            rows = judge_gains(controller, study, problem, fleets, bar.landed)
    document = judgement_document(gains, study, rows, fleets)
    if as_json:
        print(json.dumps(document, indent=2, allow_nan=False))
    else:
        show(document, Console())
    if document["verdict"] == "fail":
        raise typer.Exit(BROKEN)


def show(document: Row, console: Console) -> None:
    """Print the table and the verdict."""
    table = Table(
        title=f"{document['flights']:,} flights of a stream of their own, 95 % intervals",
        title_justify="left",
        box=SIMPLE,
        pad_edge=False,
    )
    table.add_column("", no_wrap=True)
    for name in ("limit", "value", "95 % interval", "unit", "verdict"):
        left = name in ("unit", "verdict")
        table.add_column(name, justify="left" if left else "right", no_wrap=True)
    for row in document["rows"]:
        table.add_row(*cells(row), style=STYLES.get(row["verdict"]))
    console.print(table)
    console.print(said(document), highlight=False, markup=False)


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
