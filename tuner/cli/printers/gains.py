"""Flights, guarantees and cost of gains, for a person."""

from math import degrees
from typing import TYPE_CHECKING, Any

import numpy as np

from tuner.analysis.responses import SIGNALS, UNITS
from tuner.cli.tables import Table
from tuner.cli.terminal import Console, digits
from tuner.study.processor_cost.cost import CONTROL_PERIOD

if TYPE_CHECKING:
    from tuner.api.flying import Flights
    from tuner.api.margins import Cost, Theory

Row = dict[str, Any]

SPARKS = "▁▂▃▄▅▆▇█"
# Letters of a line that stand beside its blocks: name, range and unit.
BESIDE = 36


def print_flights(flown: "Flights", console: Console) -> None:
    """Print the metrics, and the median response of each axis."""
    console.print(metrics_table(flown))
    print_sparks(flown, console)


def metrics_table(flown: "Flights") -> Table:
    """Return the metrics."""
    sortie, seeds = flown.sortie, flown.count
    laws = f"{sortie.system.cascade.position.name} / {sortie.system.cascade.attitude.name}"
    table = Table(f"{laws}: {sortie.spec.name}, {seeds} flights of {sortie.spec.duration:g} s", keys=2)
    table.columns_of("metric", "unit", "mean +- 95 %", "median", "95 % of them", "worst", left=["metric", "unit"])
    for row in flown.metrics:
        scale = row["high"] - row["low"] or row["mean"]
        half = 0.5 * (row["high"] - row["low"])
        table.add_row(
            row["metric"], row["unit"], f"{digits(row['mean'], scale)} +- {digits(half, scale)}",
            digits(row["median"], scale), digits(row["q95"], scale), digits(row["worst"], scale),
        )  # fmt: skip
    return table


def print_sparks(flown: "Flights", console: Console) -> None:
    """Print the median response of each axis as a line of blocks, with its range."""
    _, median, _ = flown.recorded.fans()
    blocks = min(max(console.width - BESIDE, 16), 64)
    columns = np.linspace(0, len(median) - 1, blocks).astype(int)
    for i, name in enumerate(SIGNALS[:6]):
        unit, factor = ("deg", degrees(1.0)) if UNITS[i] == "rad" else (UNITS[i], 1.0)
        # The range is that of the whole response, whatever part of it there is room to draw.
        low, high = factor * float(median[:, i].min()), factor * float(median[:, i].max())
        line = median[columns, i] * factor
        level = np.zeros(len(line), dtype=int) if high <= low else ((line - low) / (high - low) * 7.999).astype(int)
        print(f"{name:>6} {''.join(SPARKS[k] for k in level)}  {low:.2f} to {high:.2f} {unit} (median)")


def print_theory(theory: "Theory", console: Console) -> None:
    """Print the rows as a table, or say that theory has nothing to say."""
    rows, told = theory.document["theorems"], theory.document
    if not rows:
        console.print("No theorem speaks of these laws; `tuner list theorems` shows which it speaks of.")
        return
    scenarios = ", ".join(told["scenarios"])
    origin = f"measured in {scenarios}: {100.0 * told['level']:g} % quantile over {theory.control_period:g} s"
    table = Table(f"What theory guarantees; disturbance rate {origin}", keys=2)
    for name in ("axis", "theorem", "value", "disturbance rate", "holds"):
        table.add_column(name, justify="right" if name in ("value", "disturbance rate") else "left", no_wrap=True)
    words = {True: "yes", False: "no", None: "a bound"}
    for row in rows:
        value = "unbounded" if row["value"] is None else f"{row['value']:.4g} {row['unit']}"
        rate = f"{row['disturbance_rate']:.4g} {row['rate_unit']}"
        table.add_row(row["axis"], row["theorem"], value, rate, words[row["holds"]])
    console.print(table)
    for row in {row["theorem"]: row for row in rows}.values():
        console.print(f"{row['theorem']}: {row['quantity']}. Assumes {row['assumes']}.")


def print_costs(cost: "Cost", console: Console) -> None:
    """Print a line a controller, and below how it was counted."""
    rows = cost.document["costs"]
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
    console.print(table)
    console.print(f"Counted: {cost.document['meaning']}.")
    console.print(f"Tools: {tool(rows[0])}; {origin(rows[0])}")


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
