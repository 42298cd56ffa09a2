"""`tuner check` of a study: what it would fly, and what can be said of it before anything does."""

from math import degrees
from typing import Any

from tuner.cli.tables import Table
from tuner.cli.terminal import Console
from tuner.text.units import in_shown_units

Row = dict[str, Any]
SIGNS = {"most": "<=", "least": ">="}


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
