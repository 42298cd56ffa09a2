"""`tuner check` of a study: what it would fly, and what can be said of it before anything does."""

from math import degrees
from pathlib import Path
from typing import Any

from tuner.cli.tables import Table
from tuner.cli.terminal import Console
from tuner.experiments.tuning.conflicts import automatic_rows, told_automatic
from tuner.experiments.tuning.diagnosis import Diagnosis, told_obstacles
from tuner.experiments.tuning.guards import said_before
from tuner.experiments.tuning.preview import NARROW, beyond_reach, default_rows, is_certain, trim_rows, vehicle_row
from tuner.study import load_study
from tuner.text.units import in_shown_units

Row = dict[str, Any]
SIGNS = {"most": "<=", "least": ">="}


def check_study(study: Path) -> Row:
    """Return what a study would fly and what is known of it without flying; InputError where it is wrong."""
    asked = load_study(study)
    flights = asked.search.generations * asked.search.population * sum(entry.search for entry in asked.scenarios)
    diagnosis = Diagnosis(asked)
    beyond = beyond_reach(asked, diagnosis)
    trims = trim_rows(asked)
    return {
        "kind": "study",
        "title": asked.title,
        "variables": len(asked.space.variables),
        "objectives": [objective.label for objective in asked.objectives],
        "constraints": [entry.objective.label for entry in asked.constraints],
        "automatic_limits": automatic_rows(asked.constraints),
        "requirements": [requirement.label for requirement in asked.requirements],
        "search_flights": flights,
        "digest": asked.digest(),
        "vehicle": {"name": asked.airframe.name, **vehicle_row(asked.system.vehicle)},
        "trim": trims,
        "default": default_rows(asked, diagnosis),
        "out_of_reach": [{**entry.row(), "certain": is_certain(entry)} for entry in beyond],
        "problems": [*trim_problems(trims), *told_obstacles(beyond)],
        "warnings": said_before(asked),
        "told": told_automatic(asked.constraints),
    }  # fmt: skip


def trim_problems(trims: list[Row]) -> list[str]:
    """Return a sentence for each scenario in whose mean wind little or nothing is left of the tilt limit."""
    return [_problem(row) for row in trims if not row["held"] or row["margin"] < NARROW]


def _problem(row: Row) -> str:
    wind = f'scenario "{row["scenario"]}": the mean wind of {row["wind"]:.3g} m/s'
    if row["held"]:
        return f"{wind} leaves {degrees(row['margin']):.1f} deg to the tilt limit, which gusts will take."
    remedy = "choose a weaker intensity or mean_wind = false, or raise controller.tilt_limit_deg"
    return f"{wind} is more than the vehicle holds its place in; {remedy}."


def is_hopeless(figures: Row) -> bool:
    """Return whether a hard limit is out of reach for certain, or a mean wind is more than the vehicle can hold."""
    soft = {row["label"] for row in figures["default"] if not row["hard"]}
    return any(not row["held"] for row in figures["trim"]) or any(
        row["certain"] and row["label"] not in soft for row in figures["out_of_reach"]
    )


def show_study(figures: Row, console: Console) -> None:
    """Print it: what would fly, the vehicle, its trim, the default's margins, and what stands in the way."""
    table = Table(box=None, show_header=False)
    table.add_column("", no_wrap=True)
    table.add_column("")
    for key in ("title", "variables", "objectives", "constraints", "requirements", "search_flights", "digest"):
        value = figures[key]
        table.add_row(key, ", ".join(value) if isinstance(value, list) else str(value))
    table.add_row("vehicle", vehicle_text(figures["vehicle"]))
    for row in figures["trim"]:
        table.add_row("trim", trim_text(row))
    console.print(table)
    for text in figures["told"]:
        console.print(text, **PLAIN)
    if figures["default"]:
        console.print(default_table(figures["default"]))
    for text in figures["problems"]:
        console.print(f"Problem: {text}", style="red", **PLAIN)
    for text in figures["warnings"]:
        console.print(f"Warning: {text}", style="yellow", **PLAIN)


PLAIN: Row = {"highlight": False}


def vehicle_text(row: Row) -> str:
    """Return the vehicle in a line."""
    hover, share = row["hover_speed"]["value"], row["hover_speed_share"]["value"]
    return (
        f"{row['name']}, {row['mass']['value']:g} kg, thrust-to-weight {row['thrust_to_weight']['value']:.2f}, hovers at "
        f"{hover:.0f} rad/s ({100.0 * share:.0f} % of the largest rotor speed)"
    )


def trim_text(row: Row) -> str:
    """Return a trim in a line."""
    where = f"{row['scenario']}: mean wind {row['wind']:.3g} m/s"
    if row["tilt"] is None:
        return f"{where}, no balance"
    tilt = f"tilt {degrees(row['tilt']):.1f} deg, {degrees(row['margin']):.1f} deg to the limit"
    return f"{where}, {tilt}, thrust {row['thrust']:.2f} times the weight"


def default_table(rows: list[Row]) -> Table:
    """Return the default's margins and other known limits, loops across."""
    loops = list(dict.fromkeys(row["loop"] for row in rows if row["loop"] is not None))
    table = Table("The default gains, before any flight", keys=1)
    table.add_column("", overflow="fold")
    for name in ("limit", *loops, *([] if all(row["loop"] for row in rows) else ["all"])):
        table.add_column(name, justify="right", no_wrap=True)
    shown = [in_shown_units(row) for row in rows]
    for label in dict.fromkeys(row["label"] for row in shown):
        mine = {row["loop"]: row for row in shown if row["label"] == label}
        first = next(iter(mine.values()))
        unit = "" if first["unit"] == "1" else f" {first['unit']}"
        cells = [_cell(mine.get(loop)) for loop in (*loops, *([None] if len(table.columns) > 2 + len(loops) else []))]
        table.add_row(label, f"{SIGNS[first['sense']]} {first['limit']:g}{unit}", *cells)
    return table


def _cell(row: Row | None) -> str:
    if row is None:
        return ""
    value = "no bound" if row["value"] is None else f"{row['value']:.3g}"
    return value if row["kept"] else f"{value} {'!' if row['hard'] else '~'}"
