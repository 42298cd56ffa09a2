"""Flights of gains, for a person."""

from math import degrees
from typing import TYPE_CHECKING

import numpy as np

from tuner.cli.tables import TerminalTable
from tuner.cli.terminal import Console, digits

if TYPE_CHECKING:
    from tuner.api.flying import Flights

SPARKS = "▁▂▃▄▅▆▇█"
# Letters of a line that stand beside its blocks: name, range and unit.
LABEL_LETTERS = 36
# Lost flights that are printed.
MAX_LOST = 10


def print_flights(flown: "Flights", console: Console) -> None:
    """Print the metrics, and the median response of each axis."""
    lost = len(flown.document.lost)
    # Of a lost flight alone the metrics are costs of its loss, which say nothing of the response.
    if flown.count > lost or flown.count > 1:
        console.print(metrics_table(flown))
    if lost and flown.count > 1:
        console.print(
            f"{lost:,} of {flown.count:,} flights were lost; in every metric each of them has the cost of a loss."
        )
    print_losses(flown, console)
    print_sparks(flown, console)


def print_losses(flown: "Flights", console: Console) -> None:
    """Print the lost flights, `MAX_LOST` at most, and how to repeat one."""
    lost = flown.document.lost
    for entry in lost[:MAX_LOST]:
        console.print(f"Lost: {entry.words}.")
    if len(lost) > MAX_LOST:
        console.print(f"{len(lost) - MAX_LOST:,} more were lost; --json names them all.")
    if len(lost) and flown.count > 1:
        console.print(f"One of them again, drawn: the same command with --flight {lost[0].name} --plot lost.png")


def metrics_table(flown: "Flights") -> TerminalTable:
    """Return the metrics."""
    setup, seeds = flown.flight_setup, flown.count
    table = TerminalTable(f"{setup.laws}: {setup.spec.name}, {seeds} flights of {setup.spec.duration:g} s", keys=2)
    table.columns_of("metric", "unit", "mean +- 95 %", "median", "95 % of them", "worst", left=("metric", "unit"))
    for row in flown.document.metrics:
        half = 0.5 * (row.high - row.low)
        scale = 2.0 * half or row.mean
        mean = f"{digits(row.mean, scale)} +- {digits(half, scale)}"
        if row.count is not None:
            mean = row.count.words if row.count.events == 0 else f"{row.mean:.2g} [{row.low:.2g}, {row.high:.2g}]"
        table.add_row(
            row.metric,
            row.unit,
            mean,
            digits(row.median, scale),
            digits(row.q95, scale),
            digits(row.worst, scale),
        )
    return table


def print_sparks(flown: "Flights", console: Console) -> None:
    """Print the median response of each axis as blocks, with its range."""
    _, median, _ = flown.recorded.fans()
    blocks = min(max(console.width - LABEL_LETTERS, 16), 64)
    columns = np.linspace(0, len(median) - 1, blocks).astype(int)
    flights = flown.recorded
    # Commands follow nothing.
    following = [i for i in range(len(flights.signals)) if not np.isnan(flights.reference[..., i]).all()]
    width = max(6, *[len(flights.signals[i]) for i in following])
    for i in following:
        name, given = flights.signals[i], flights.units[i]
        unit, factor = ("deg", degrees(1.0)) if given == "rad" else (given, 1.0)
        # The range is that of the whole response, whatever part of it there is room to draw.
        flown_part = factor * median[np.isfinite(median[:, i]), i]
        if len(flown_part):
            low, high = float(flown_part.min()), float(flown_part.max())
            line = sparks(factor * median[columns, i], low, high)
            print(f"{name:>{width}} {line}  {low:.2f} to {high:.2f} {unit} (median)")


def sparks(values: np.ndarray, low: float, high: float) -> str:
    """Return values (n,) as blocks between two ends, blanks for NaN."""
    shares = np.where(np.isfinite(values), values - low, np.nan) / (high - low if high > low else 1.0)
    return "".join(SPARKS[int(share * 7.999)] if np.isfinite(share) else " " for share in shares)
