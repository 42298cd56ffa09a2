"""The command `tuner fit`."""

from pathlib import Path
from typing import Annotated

import typer

import tuner
from plant.errors import InputError
from tuner.cli.answer import answer
from tuner.cli.app import AsJson, app
from tuner.text.pairs import named_text


@app.command()
def fit(
    data: Annotated[
        list[Path],
        typer.Argument(help="CSV tables of one plant, one for each experiment.", show_default=False, metavar="DATA..."),
    ],
    inputs: Annotated[str, typer.Option("--input", help="Columns of the inputs, separated by commas.")],
    outputs: Annotated[str, typer.Option("--output", help="Columns of the outputs, separated by commas.")],
    time: Annotated[str, typer.Option(help="Column of the time [s]; default: time or t.")] = "",
    period: Annotated[float | None, typer.Option(help="Sampling interval [s] of a table without a time.")] = None,
    before: Annotated[
        str | None,
        typer.Option(help="Values of the inputs before the first row, separated by commas; default: its own."),
    ] = None,
    structure: Annotated[
        str, typer.Option(help="Structures that compete, separated by commas, such as first-order; default: all.")
    ] = "",
    max_dead_time: Annotated[
        float | None, typer.Option(help="Largest dead time [s]; default: a fifth of the longest record.")
    ] = None,
    drift: Annotated[bool, typer.Option("--drift", help="Estimate a straight drift of the outputs.")] = False,
    unit: Annotated[
        list[str] | None, typer.Option(help="Unit of a column, such as temperature=K; repeat it for others.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Study to write (TOML), with plant, spread and noise.")] = None,
    law: Annotated[str, typer.Option(help="Law of the study's loops: pi, pid, adrc or ladrc.")] = "pid",
    report: Annotated[Path | None, typer.Option(help="Write an HTML page: data, fit, residuals, step, Bode.")] = None,
    as_json: AsJson = False,
) -> None:
    """Fit a plant with 95 % intervals to measured inputs and outputs.

    The structure is the simplest that predicts held-out blocks as well as any. Plant and noise are fitted together, so data of a
    closed loop may be given too.

    Example: tuner fit step.csv --input heater --output temperature --out heater.toml --report heater.html
    """
    result = tuner.fit(
        data,
        input=inputs,
        output=outputs,
        time=time,
        period=period,
        before=None if before is None else numbers_of(before),
        structure=structure,
        max_dead_time=max_dead_time,
        drift=drift,
        units=units_of(unit or []),
        out=out,
        law=law,
        report=report,
    )
    answer(result, as_json)


def numbers_of(given: str) -> list[float]:
    """Return the numbers in a list with commas; InputError where one is none."""
    try:
        return [float(each) for each in given.split(",")]
    except ValueError:
        raise InputError(f"given '{given[:60]}'; give numbers separated by commas", key="--before") from None


def units_of(given: list[str]) -> dict[str, str]:
    """Return units by column from texts NAME=UNIT; InputError where one is none."""
    return dict(named_text(each, "--unit", "temperature=K", "COLUMN=UNIT") for each in given)
