"""Tables of finished runs as texts: for the terminal, for Markdown, and as LaTeX for a paper.

Values have the digits that their 95 % intervals support, in shown units: angles in degrees, gains of margins in dB.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from objectives.margins.quantities import QUANTITIES
from tuner.documents.contest import ComparedFolder
from tuner.documents.parts import Estimate, on_page
from tuner.documents.summary import TableRow
from tuner.documents.tuning import DEFAULT, SHOWN, TUNED, TuningFolder
from tuner.documents.tuning_tables import LOOP_MARGINS
from tuner.documents.verdicts import NO_DIFFERENCE, shown_verdict
from tuner.report.labels import plain_label
from tuner.report.verdict_text import named
from tuner.text.numbers import estimate, fixed, significant
from tuner.text.sentences import bound_text
from tuner.text.tables import Table
from tuner.text.units import bracketed

Views = Mapping[str, Callable[[], Table]]
"""Tables by name, each made when it is called."""
JUDGED = ("objective", "constraint")


def tuning_views(results: TuningFolder) -> Views:
    """Return the tables of a tuning run."""
    return {
        "objectives": lambda: objectives_view(results),
        "limits": lambda: limits_view(results),
        "gains": lambda: gains_view(results),
        "front": lambda: front_view(results),
        "margins": lambda: margins_view(results),
    }


def compared_views(results: ComparedFolder[Any]) -> Views:
    """Return the tables of a contest or a comparison."""
    return {"values": lambda: values_view(results), "differences": lambda: differences_view(results)}


def objectives_view(results: TuningFolder) -> Table:
    """Return default, tuned and change of each objective."""
    head = ("objective", "default", results.shown_as, "change")
    rows = [on_page(row, *SHOWN) for row in results.document.table if row.kind == "objective"]
    cells = [
        (_title(results, row), _text(row.default), _text(row.tuned), _text(row.difference, signed=True)) for row in rows
    ]
    return Table(f"{results.document.title}: objectives", head, cells, head[:1])


def limits_view(results: TuningFolder) -> Table:
    """Return default and tuned of each limit, and the verdict on it."""
    head = ("limit", "default", results.shown_as, "allowed", "verdict")
    rows = [on_page(row, *SHOWN) for row in results.document.table if row.limit is not None]
    cells = [
        (
            _title(results, row),
            _text(row.default),
            _text(row.tuned),
            bound_text(row.limit or 0.0, row.sense),
            shown_verdict(row.verdict),
        )
        for row in rows
    ]
    return Table(f"{results.document.title}: limits", head, cells, ("limit", "allowed", "verdict"))


def gains_view(results: TuningFolder) -> Table:
    """Return the searched gains with their ranges."""
    head = ("gain", "default", results.shown_as, "range")
    cells = [
        (
            bracketed(row.name, _unit(row.unit)),
            significant(row.default),
            significant(row.tuned),
            f"{significant(row.low)} to {significant(row.high)}",
        )
        for row in results.variables
    ]
    return Table(f"{results.document.title}: gains", head, cells, ("gain", "range"))


def front_view(results: TuningFolder) -> Table:
    """Return held-out objectives and limited margins of default and front."""
    front = results.held_out_front
    shown = {row: [on_page(part, *SHOWN) for part in _on_front(results.rows_of(row))] for row in front.shown_rows}
    titles = [_title(results, part) for part in next(iter(shown.values()))]
    names = [_point(front.points[row], front.roles[row]) for row in shown]
    cells = [(name, *[_text(part.tuned) for part in parts]) for name, parts in zip(names, shown.values(), strict=True)]
    return Table(f"{results.document.title}: held-out front", ("point", *titles), cells, ("point",))


def margins_view(results: TuningFolder) -> Table:
    """Return the margins of each loop, of default and tuned gains."""
    quantities = [QUANTITIES[name] for name in LOOP_MARGINS]
    head = ("gains", "loop", *[bracketed(entry.label, _unit(entry.shown_unit)) for entry in quantities])
    front = results.held_out_front
    roles = {DEFAULT: DEFAULT, TUNED: results.shown_as}
    cells = [
        (
            roles[role],
            loop.channel,
            *[_reading(loop.values[entry.name], entry.shown, entry.digits) for entry in quantities],
        )
        for role in roles
        for loop in results.loops
        if front.role(loop.point) == role
    ]
    return Table(f"{results.document.title}: margins", head, cells, head[:2])


def values_view(results: ComparedFolder[Any]) -> Table:
    """Return objectives and limited quantities of each contender."""
    judged = [row for row in results.shown.quantities if row.kind in JUDGED]
    head = ("contender", *[bracketed(_quantity(results, row.label), row.unit) for row in judged])
    cells = [
        (entry.name, *[_text(results.estimates[entry.name, row.label]) for row in judged])
        for entry in results.contenders
    ]
    return Table(f"{results.document.title}: values", head, cells, head[:1])


def differences_view(results: ComparedFolder[Any]) -> Table:
    """Return the paired differences of each two contenders."""
    head = ("pair", "quantity", "difference", "lower")
    cells = [
        (
            f"{row.second} − {row.first}",
            bracketed(_quantity(results, row.quantity), results.quantity[row.quantity].unit),
            _text(row.estimate, signed=True),
            row.lower or shown_verdict(NO_DIFFERENCE),
        )
        for row in results.shown.differences
    ]
    return Table(f"{results.document.title}: paired differences", head, cells, ("pair", "quantity", "lower"))


VIEWS: dict[str, Callable[[Any], Views]] = {
    "tuning": tuning_views,
    "contest": compared_views,
    "comparison": compared_views,
}
"""Kind of results -> their tables."""


def _on_front(rows: Sequence[TableRow]) -> list[TableRow]:
    return [row for row in rows if row.kind in ("objective", "requirement")]


def _title(results: TuningFolder, row: TableRow) -> str:
    return bracketed(named(results, row, short=True), row.unit)


def _quantity(results: ComparedFolder[Any], label: str) -> str:
    row = results.quantity[label]
    has_rotors = any(entry.airframe is not None for entry in results.contenders)
    return plain_label(label, row.metric, row.scenario, has_rotors, short=True)


def _point(name: str, role: str) -> str:
    return name if role in ("", name) else f"{name} ({role})"


def _unit(unit: str) -> str:
    return "" if unit == "1" else unit


def _text(entry: Estimate, signed: bool = False) -> str:
    value, ends = estimate(*entry, signed=signed)
    return value if entry.low is None else f"{value} {ends}"


def _reading(value: float | None, shown: Callable[[float], float], digits: int) -> str:
    return "∞" if value is None else fixed(shown(value), digits)
