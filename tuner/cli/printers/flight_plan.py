"""Printer of an experiment to fly."""

from typing import TYPE_CHECKING

from tuner.cli.tables import TerminalTable
from tuner.cli.terminal import Console
from tuner.report.flight_plan_words import EXCITATIONS, NUMBERS, PEAKS, excitation_rows, number_row, peak_rows

if TYPE_CHECKING:
    from tuner.api.flight_plans import FlightPlan


def print_flight_plan(found: "FlightPlan", console: Console) -> None:
    """Print the excitations, the intervals before and after, the limits and the verdict."""
    document = found.document
    flight = TerminalTable(f"A flight of {document.duration:.0f} s, for {document.target}", keys=1)
    flight.columns_of(*EXCITATIONS, left=("", "unit", "of its", "wave"))
    for row in excitation_rows(document):
        flight.add_row(*row)
    widths = TerminalTable("Half-widths of 95 % intervals", keys=1).columns_of(*NUMBERS, left=("", "unit"))
    for row in document.numbers:
        widths.add_row(*number_row(row), style=None if row.asked is not None else "yellow")
    peaks = TerminalTable(f"The most of {document.flights} simulated flights in {document.scenario}", keys=1)
    peaks.columns_of(*PEAKS, left=("", "unit"))
    for row in peak_rows(document):
        peaks.add_row(*row)
    for part in (flight, widths, peaks, *document.notes, document.verdict):
        console.print(part)
    if found.folder is not None:
        console.print(f"Written: {', '.join(str(found.folder / name) for name in document.files)}.")
