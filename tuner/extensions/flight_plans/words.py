"""Tables of an experiment to fly, for page and terminal."""

from tuner.extensions.flight_plans.document import FlightPlanDocument, PlannedNumber
from tuner.text.numbers import significant
from tuner.text.tables import Table
from tuner.text.units import in_degrees


def excitation_table(document: FlightPlanDocument) -> Table:
    """Return a row for each excitation."""
    rows = []
    for row in document.excitations:
        unit, factor = in_degrees(row.unit)
        times = (f"{row.begin:.0f} s", f"{row.duration:.0f} s")
        amplitude = significant(factor * row.amplitude, 3)
        rows.append((row.axis, *times, amplitude, unit, row.quantity, f"{row.first:g} to {row.last:g} Hz", row.wave))
    head = ("", "from", "lasts", "amplitude", "unit", "of its", "band", "wave")
    title = f"A flight of {document.duration:.0f} s, for {document.target}"
    return Table(title, head, rows, ("", "unit", "of its", "wave"))


def number_table(numbers: list[PlannedNumber]) -> Table:
    """Return a row for each number; those without a target are marked.

    Widths are in per cent of a positive number, in the unit of others.
    """
    head = ("", "value", "unit", "before", "asked", "foreseen", "obtained", "")
    marked = [i for i, row in enumerate(numbers) if row.target is None]
    return Table("Half-widths of 95 % intervals", head, [_number_row(row) for row in numbers], ("", "unit"), marked)


def peak_table(document: FlightPlanDocument) -> Table:
    """Return a row for each peak."""
    rows = []
    for row in document.peaks:
        unit, factor = in_degrees(row.unit)
        limit = "" if row.limit is None else significant(factor * row.limit, 3)
        rows.append((row.meaning, significant(factor * row.peak, 3), limit, unit))
    title = f"The most of {document.flights} simulated flights in {document.scenario}"
    return Table(title, ("", "comes to", "limit", "unit"), rows, ("", "unit"))


def _number_row(row: PlannedNumber) -> tuple[str, ...]:
    widths = [_width(row, width) for width in (row.before, row.target, row.foreseen, row.obtained)]
    return (row.name, significant(row.value, 3), "" if row.unit == "1" else row.unit, *widths, row.reason)


def _width(row: PlannedNumber, width: float | None) -> str:
    if width is None:
        return ""
    return f"{significant(100.0 * width, 2)} %" if row.relative else significant(width, 2)
