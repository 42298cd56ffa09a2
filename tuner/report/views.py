"""Tables of finished runs as texts: for the terminal, for Markdown, and as LaTeX for a paper.

Values have the digits that their 95 % intervals support, in shown units: angles in degrees, gains of margins in dB.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from objectives.margins.quantities import QUANTITIES
from tuner.documents.comparison import ComparedFolder
from tuner.documents.margins import MarginsDocument
from tuner.documents.parts import Estimate, on_page
from tuner.documents.summary import TableRow
from tuner.documents.tuning import DEFAULT, SHOWN, TUNED, TuningFolder
from tuner.documents.tuning_tables import LOOP_MARGINS, Loop
from tuner.documents.verdicts import shown_verdict
from tuner.report.labels import compared_label, named, time_unit
from tuner.text.numbers import estimate, significant
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
    """Return the tables of a comparison."""
    views: dict[str, Callable[[], Table]] = {
        "values": lambda: values_view(results),
        "differences": lambda: differences_view(results),
    }
    if any(entry.folder is not None for entry in results.contenders):
        views["margins"] = lambda: contender_margins_view(results)
    return views


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
    roles = {DEFAULT: DEFAULT, TUNED: results.shown_as}
    loops = [(roles[role], loop) for role in roles for loop in _loops(results, role)]
    return _margins_table(results.document.title, "gains", loops)


def contender_margins_view(results: ComparedFolder[Any]) -> Table:
    """Return the margins of each loop of the contenders that were tuned."""
    loops = [
        (entry.name, loop)
        for entry in results.contenders
        if entry.folder is not None
        for loop in _loops(TuningFolder(results.home / entry.folder), TUNED)
    ]
    return _margins_table(results.document.title, "contender", loops)


def values_view(results: ComparedFolder[Any]) -> Table:
    """Return objectives and limited quantities of each contender."""
    judged = [row for row in results.shown.quantities if row.kind in JUDGED]
    head = ("contender", *[bracketed(compared_label(results, row.label), row.unit) for row in judged])
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
            bracketed(compared_label(results, row.quantity), results.quantity[row.quantity].unit),
            _text(row.estimate, signed=True),
            row.lower or row.verdict,
        )
        for row in results.shown.differences
    ]
    return Table(f"{results.document.title}: paired differences", head, cells, ("pair", "quantity", "lower"))


def _loops(results: TuningFolder, role: str) -> list[Loop]:
    return [loop for loop in results.loops if results.held_out_front.role(loop.point) == role]


def loops_view(document: MarginsDocument) -> Table:
    """Return the margins of each loop in shown units."""
    values = [
        {name: reading.value for name, reading in loop.quantities.items() if name in LOOP_MARGINS}
        for loop in document.channels
    ]
    heads, cells = _margin_cells(values)
    rows = [
        (loop.channel, *(numbers if loop.stable else ["-"] * len(heads)))
        for loop, numbers in zip(document.channels, cells, strict=True)
    ]
    return Table("margins", ("loop", *heads), rows, ("loop",))


def _margins_table(title: str, whose: str, loops: Sequence[tuple[str, Loop]]) -> Table:
    """Return a table with a row for each loop."""
    heads, cells = _margin_cells([loop.values for _, loop in loops])
    rows = [(name, loop.channel, *numbers) for (name, loop), numbers in zip(loops, cells, strict=True)]
    return Table(f"{title}: margins", (whose, "loop", *heads), rows, (whose, "loop"))


def _margin_cells(loops: Sequence[Mapping[str, float | None]]) -> tuple[list[str], list[tuple[str, ...]]]:
    """Return heads and rows of the margins of loops: each quantity in one unit."""
    heads, columns = list[str](), list[list[str]]()
    for name in (name for name in LOOP_MARGINS if all(name in loop for loop in loops)):
        quantity, values = QUANTITIES[name], [loop[name] for loop in loops]
        unit, size = time_unit(name, values)
        heads.append(bracketed(quantity.label, _unit(unit)))
        columns.append(
            [
                quantity.infinite_text("∞") if value is None else significant(quantity.shown(value) / size, 3)
                for value in values
            ]
        )
    return heads, list(zip(*columns, strict=True))


def _on_front(rows: Sequence[TableRow]) -> list[TableRow]:
    return [row for row in rows if row.kind in ("objective", "requirement")]


def _title(results: TuningFolder, row: TableRow) -> str:
    return bracketed(named(results, row, short=True), row.unit)


def _point(name: str, role: str) -> str:
    return name if role in ("", name) else f"{name} ({role})"


def _unit(unit: str) -> str:
    return "" if unit == "1" else unit


def _text(entry: Estimate, signed: bool = False) -> str:
    value, ends = estimate(*entry, signed=signed)
    return value if entry.low is None else f"{value} {ends}"
