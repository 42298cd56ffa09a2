"""Printer of a forecast."""

from math import degrees, inf
from typing import TYPE_CHECKING

from tuner.cli.tables import TerminalTable
from tuner.cli.terminal import Console
from tuner.extensions.betaflight_adrc.document import AdrcDocument, PlantRow, RingRow
from tuner.extensions.betaflight_adrc.ringing import worst_ring

if TYPE_CHECKING:
    from tuner.extensions.betaflight_adrc.api import AdrcForecast

COLUMNS = (("gain", 1.0, 1), ("lag", 1e3, 1), ("dead_time", 1e3, 1), ("zero", 1e3, 0), ("b0", 1.0, 0))
"""Numbers of a plant: name, factor to the printed unit, digits."""


def print_adrc_forecast(made: "AdrcForecast", console: Console) -> None:
    """Print the plants, margins by throttle, the schedules, changes, and the answer."""
    document = made.document
    console.print(
        f"{document.file}: profile {document.profile}, build {document.build}, {document.loop_rate:.0f} Hz",
        markup=False,
    )
    for table in (_plants(document), _margins(document), _schedules(document), _changes(document)):
        console.print(table)
    if any(row.pack != 1.0 for row in document.rings):
        console.print(_packs(document))
    if document.design:
        console.print(_design(document))
    for note in document.notes:
        console.print(note, markup=False)
    console.print(document.sentence, style="bold", markup=False)


def _plants(document: AdrcDocument) -> TerminalTable:
    table = TerminalTable("Plant at hover, times in ms, +- of 95 % intervals; its b0 is no setting", keys=1)
    table.columns_of("", "gain [deg/s2]", "lag", "dead time", "zero", "plant's b0 [deg/s3]", left=("",))
    for row in document.plants:
        table.add_row(row.axis, *(_number(row, *column) for column in COLUMNS))
    return table


def _number(row: PlantRow, name: str, factor: float, digits: int) -> str:
    """Return a number of a plant, with the half-width of its interval."""
    text = f"{factor * getattr(row, name):.{digits}f}"
    if name not in row.intervals:
        return text
    low, high = row.intervals[name]
    return f"{text} +- {0.5 * factor * (high - low):.{digits}f}"


def _of_schedule(document: AdrcDocument, gate: str, pack: float = 1.0) -> list[RingRow]:
    rows = [row for row in document.rings if row.schedule == document.schedule and row.gate == gate]
    return [row for row in rows if row.pack == pack]


def _margins(document: AdrcDocument) -> TerminalTable:
    """Return the margins with the tune's own schedule, and on the ground."""
    table = TerminalTable(
        f"Gain margin (below 1 it rings), frequency and phase margin with {document.schedule}", keys=1
    )
    table.columns_of("", "throttle", "gain margin", "rings at [Hz]", "phase margin [deg]", left=("",))
    for row in (*_of_schedule(document, "open"), *_of_schedule(document, "shut")):
        where = f"{100.0 * row.throttle:.0f} %" if row.gate == "open" else "ground"
        phase = "-" if row.phase_margin is None else f"{degrees(row.phase_margin):.0f}"
        ring = "-" if row.ring is None else f"{row.ring:.0f}"
        style = "bold" if row == document.rings[document.worst] else None
        table.add_row(row.axis, where, _factor(row), ring, phase, style=style)
    return table


def _schedules(document: AdrcDocument) -> TerminalTable:
    """Return the smallest gain margin of the axes by throttle and schedule."""
    rows = [row for row in document.rings if row.gate == "open" and row.pack == 1.0]
    schedules = list(dict.fromkeys(row.schedule for row in rows))
    table = TerminalTable("Smallest gain margin by schedule of b0", keys=1)
    table.columns_of("throttle", *schedules)
    for throttle in sorted({row.throttle for row in rows}):
        cells = [[row for row in rows if (row.schedule, row.throttle) == (name, throttle)] for name in schedules]
        worst = [min(cell, key=lambda row: row.gain_margin or inf) for cell in cells]
        table.add_row(f"{100.0 * throttle:.0f} %", *[f"{row.axis} {_factor(row)}" for row in worst])
    return table


def _packs(document: AdrcDocument) -> TerminalTable:
    """Return the smallest gain margin of each pack."""
    table = TerminalTable("Smallest gain margin by voltage of the pack", keys=1)
    table.columns_of("pack", "axis", "throttle", "gain margin", "rings at [Hz]")
    for pack in dict.fromkeys(row.pack for row in document.rings):
        worst = worst_ring(_of_schedule(document, "open", pack), document.schedule)
        table.add_row(
            f"x {pack:g}", worst.axis, f"{100.0 * worst.throttle:.0f} %", _factor(worst), f"{worst.ring or 0.0:.0f}"
        )
    return table


def _factor(row: RingRow) -> str:
    return "-" if row.gain_margin is None else f"{row.gain_margin:.2f}"


def _changes(document: AdrcDocument) -> TerminalTable:
    worst = document.rings[document.worst]
    table = TerminalTable(f"Single changes, {worst.axis} at {100.0 * worst.throttle:.0f} % throttle", keys=1)
    table.columns_of("", "gain margin", "rings at [Hz]", "stiffness at 2 Hz", "noise", left=("",))
    table.add_row("as it is", _factor(worst), "-" if worst.ring is None else f"{worst.ring:.0f}", "x 1.00", "x 1.00")
    for row in document.changes:
        names = ", ".join(f"{name} = {value:.0f}" for name, value in row.settings.items())
        effects = f"{row.gain_margin:.2f}", f"{row.ring:.0f}", f"x {row.stiffness:.2f}", f"x {row.noise:.2f}"
        table.add_row(names, *effects)
    return table


def _design(document: AdrcDocument) -> TerminalTable:
    table = TerminalTable("Stiffest tune by gain margin at every throttle and pack", keys=1)
    heads = ("margin", "wc", "wo", "rings at [Hz]", "bandwidth [Hz]", "stiffness", "noise")
    table.columns_of("", *heads, left=("",))
    for row in document.design:
        numbers = (f"{value:.0f}" for value in (row.wc, row.wo, row.ring, row.bandwidth))
        table.add_row(row.axis, f"{row.wanted:g}", *numbers, f"x {row.stiffness:.2f}", f"x {row.noise:.2f}")
    return table
