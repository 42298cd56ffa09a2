"""The command `tuner cost`."""

from pathlib import Path
from typing import Annotated

import typer

import tuner
from plant.errors import InputError
from tuner.api import POSITION_LAW
from tuner.cli.answer import answer
from tuner.cli.app import AsJson, app, law_option


@app.command()
def cost(
    gains: Annotated[
        Path | None, typer.Argument(help="A gains.json; leave out for laws at their default gains.")
    ] = None,
    law: Annotated[str | None, law_option("Attitude law; leave out for all.")] = None,
    position_law: Annotated[str, law_option("Position law, with --law or for all.")] = POSITION_LAW,
    measure: Annotated[
        bool, typer.Option("--measure", help="Measure with arm-none-eabi-gcc and qemu-system-arm.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Report instructions, code and memory on a Cortex-M4F.

    Example: tuner cost --law hybrid
    """
    if gains is not None and law is not None:
        raise InputError("give either a gains.json or --law NAME; without both, all attitude laws are listed")
    given = gains if law is None else tuner.default_gains(law, position_law)
    answer(tuner.cost(given, position=position_law, measure=measure), as_json)
