"""Tables of an experiment to fly, as texts for page and terminal."""

from tuner.documents.flight_plan import FlightPlanDocument, PlannedNumber
from tuner.text.numbers import significant
from tuner.text.units import in_degrees

EXCITATIONS = ("", "from", "lasts", "amplitude", "unit", "of its", "band", "wave")
NUMBERS = ("", "value", "unit", "before", "asked", "foreseen", "obtained", "")
PEAKS = ("", "comes to", "limit", "unit")
"""Heads of the tables."""


def excitation_rows(document: FlightPlanDocument) -> list[tuple[str, ...]]:
    """Return a row for each excitation."""
    rows = []
    for row in document.excitations:
        unit, factor = in_degrees(row.unit)
        times = (f"{row.begin:.0f} s", f"{row.duration:.0f} s")
        amplitude = significant(factor * row.amplitude, 3)
        rows.append((row.axis, *times, amplitude, unit, row.quantity, f"{row.first:g} to {row.last:g} Hz", row.wave))
    return rows


def number_row(row: PlannedNumber) -> tuple[str, ...]:
    """Return the row of a number, widths in per cent of a positive one and in the unit of others."""
    widths = [_width(row, width) for width in (row.before, row.asked, row.foreseen, row.obtained)]
    return (row.name, significant(row.value, 3), "" if row.unit == "1" else row.unit, *widths, row.reason)


def peak_rows(document: FlightPlanDocument) -> list[tuple[str, ...]]:
    """Return a row for each peak."""
    rows = []
    for row in document.peaks:
        unit, factor = in_degrees(row.unit)
        limit = "" if row.limit is None else significant(factor * row.limit, 3)
        rows.append((row.meaning, significant(factor * row.peak, 3), limit, unit))
    return rows


def _width(row: PlannedNumber, width: float | None) -> str:
    if width is None:
        return ""
    return f"{significant(100.0 * width, 2)} %" if row.relative else significant(width, 2)
