"""`tuner cost`: instructions and bytes of a control step on a microcontroller, of one controller or of all attitude laws."""

import json
from pathlib import Path
from typing import Any

from plant.errors import InputError
from plant.laws import LAWS
from tuner.cli.fly import controller_of
from tuner.cli.tables import Table
from tuner.cli.terminal import Console
from tuner.exchange.processor_cost.measure import default_controller
from tuner.gains import Controller
from tuner.study.processor_cost.cost import MEANING
from tuner.study.processor_cost.table import CONTROL_PERIOD, tabled

Row = dict[str, Any]


def cost_command(gains: Path | None, law: str | None, position_law: str, measure: bool, as_json: bool) -> None:
    """Print what a controller costs: counted now, or as the packaged table has it."""
    if gains is not None and law is not None:
        raise InputError("give either a gains.json or --law NAME; without both, all attitude laws are listed")
    if gains is None and law is None:
        rows = [row_of(default_controller(position_law, name), measure) for name in LAWS]
    else:
        rows = [row_of(controller_of(gains, law, position_law, None), measure)]
    if as_json:
        print(json.dumps({"meaning": MEANING, "costs": rows}, indent=2, allow_nan=False))
    else:
        print_costs(rows)


def row_of(controller: Controller, measure: bool) -> Row:
    """Return the cost of a controller with its laws and its period; measured where asked for, or where the table has none."""
    position, attitude = controller.cascade.position.name, controller.cascade.attitude.name
    cost = None if measure else tabled(position, attitude)
    measured = cost is None
    if cost is None:
        from tuner.exchange.processor_cost.measure import measure_cost

        cost = measure_cost(controller)
    return {
        "position": position,
        "attitude": attitude,
        "control_period": {"value": controller.control_period, "unit": "s"},
        "instructions_per_second": cost.per_second(controller.control_period),
        "measured": measured,
        **cost.as_dict(),
    }


def print_costs(rows: list[Row]) -> None:
    """Print a line a controller, and below how it was counted."""
    period = rows[0]["control_period"]["value"]
    title = f"Instructions and bytes on a {rows[0]['target']} (mean, largest), position law {rows[0]['position']}"
    table = Table(title, keys=1)
    table.add_column("attitude law", no_wrap=True)
    at = f"{1.0 / period:.4g} Hz"
    for name in (
        "attitude\nloops",
        "whole\ncascade",
        f"million/s\nat {at}",
        "code\nbyte",
        "state\nbyte",
        "stack\nbyte",
    ):
        table.add_column(name, justify="right", no_wrap=True)
    for row in rows:
        table.add_row(
            row["attitude"], _counted(row, "attitude"), _counted(row, "step"),
            f"{1e-6 * row['instructions_per_second']:.3f}",
            *[str(row[f"{what}_bytes"]) for what in ("text", "state", "stack")],
        )  # fmt: skip
    console = Console()
    console.print(table)
    console.print(f"Counted: {MEANING}.", highlight=False)
    console.print(f"Tools: {tool(rows[0])}; {origin(rows[0])}", highlight=False)


def tool(row: Row) -> str:
    """Return compiler, flags and emulator."""
    return f"{row['compiler']} ({row['flags']}), {row['emulator']}"


def origin(row: Row) -> str:
    """Say where a row comes from."""
    if row["measured"]:
        return "counted just now."
    return f"from the packaged table, at default gains and {1e3 * CONTROL_PERIOD:g} ms; --measure counts these gains."


def _counted(row: Row, what: str) -> str:
    return f"{row[f'instructions_{what}']:.0f}, {row[f'most_{what}']}"
