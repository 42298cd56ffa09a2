"""Texts that the page shows of each finalist, and the rows of its gains file; its scripts put them in place and judge nothing."""

from collections.abc import Sequence
from typing import TypedDict

from objectives.margins.quantities import QUANTITIES
from tuner.documents.finalists import FINALIST_COLUMNS, FinalistColumn
from tuner.documents.parts import Estimate, on_page
from tuner.documents.summary import TableRow
from tuner.documents.tuning import DEFAULT, SHOWN, TuningFolder
from tuner.documents.tuning_tables import LOOP_MARGINS, Loop
from tuner.report.answer_section import signed_verdict
from tuner.report.gains_section import place_of, place_remark
from tuner.report.labels import definition_text, named, time_unit
from tuner.report.why_not import why_not
from tuner.text.numbers import MISSING, estimate, per_cent, significant
from tuner.text.sentences import bound_text, capitalized
from tuner.text.units import plain

STATES = {
    "default": "the default",
    "front": "on the held-out front",
    "finalist": "off the front when held out",
    "start": "design start, search values",
    "searched": "feasible, search values",
    "infeasible": "violates a limit, search values",
}
"""Layer of a point -> what it is; of the point next to the default the page knows what it is called."""
Cell = tuple[str, str]
"""A number and its interval, "" where it has none."""


class Place(TypedDict):
    """Texts of a gain, and where it lies in its range, 0 to 1."""

    value: str
    place: float
    remark: str


class QuantityCells(TypedDict):
    """Cells of a quantity of a point: its value, the difference to the default, and the verdict with its sign and class."""

    value: Cell
    difference: Cell
    verdict: str
    style: str


class PointTexts(TypedDict):
    """Texts of a finalist.

    state: a sentence; why: see `why_not`; faults: limits broken and flights lost, "" for none; values: cells of the objectives;
    columns: cells of `FINALIST_COLUMNS` with a heading; gains, quantities, loops: rows of its three tables.
    """

    state: str
    why: str
    faults: str
    values: list[Cell]
    columns: list[str]
    gains: list[Place]
    quantities: list[QuantityCells]
    loops: list[list[str]]


class QuantityTexts(TypedDict):
    """Texts of a quantity that every point has: what it is, its limit, and the default's value."""

    label: str
    definition: str
    unit: str
    limit: str
    default: Cell


def point_texts(results: TuningFolder, row: int) -> PointTexts:
    """Return the texts of a finalist by its row of the front."""
    front = results.held_out_front
    name = front.points[row]
    ends = zip(*(values[row].tolist() for values in (front.held_out, front.low, front.high)), strict=True)
    units = margin_units(results)
    return {
        "state": _state(results, row),
        "why": why_not(results, row),
        "faults": ", ".join(_faults(results, row)),
        "values": [estimate(value, low, high) for value, low, high in ends],
        "columns": [_column(entry, results, row) for entry in FINALIST_COLUMNS if entry.heading],
        "gains": [
            {"value": significant(value), "place": place_of(variable, value), "remark": place_remark(variable, value)}
            for variable, value in zip(results.variables, front.gains[row].tolist(), strict=True)
        ],
        "quantities": [_judged(entry) for entry in results.rows_of(row)],
        "loops": [_loop(loop, units) for loop in results.loops if loop.point == name],
    }


def quantity_texts(results: TuningFolder) -> list[QuantityTexts]:
    """Return the texts of every quantity in the order of `PointTexts.quantities`."""
    names = results.held_out_front.points
    rows = results.rows_of(names.index(DEFAULT) if DEFAULT in names else 0)
    return [_quantity(results, stored, on_page(stored, *SHOWN)) for stored in rows]


def patch(row: TableRow) -> dict[str, object]:
    """Return the keys of an objective of gains.json that differ from point to point, with those that find it."""
    return row.model_dump(include={"kind", "label", "default", "tuned", "difference", "verdict"})


def _quantity(results: TuningFolder, stored: TableRow, shown: TableRow) -> QuantityTexts:
    return {
        "label": named(results, stored, short=True),
        "definition": definition_text(stored),
        "unit": plain(shown.unit) or MISSING,
        "limit": MISSING if shown.limit is None else bound_text(shown.limit, shown.sense),
        "default": _cell(shown.default),
    }


def _judged(stored: TableRow) -> QuantityCells:
    shown = on_page(stored, *SHOWN)
    return {
        "value": _cell(shown.tuned),
        "difference": _cell(shown.difference, signed=True),
        "verdict": signed_verdict(shown.verdict),
        "style": shown.verdict.replace(" ", "-"),
    }


def _cell(entry: Estimate, signed: bool = False) -> Cell:
    value, interval = estimate(*entry.parts, signed)
    if interval == MISSING and signed and entry.value is not None and entry.value > 0.0:
        value = f"+{value}"
    return value, "" if interval == MISSING else interval


def _state(results: TuningFolder, row: int) -> str:
    front = results.held_out_front
    lost = _lost(results, row)
    behind = f" {capitalized(lost)}" if lost else ""
    if front.roles[row] == DEFAULT:
        return f"The default gains, the baseline of every comparison.{behind}"
    first = f"It is {'' if front.non_dominated[row] else 'not '}on the held-out front"
    probability = front.columns.get("probability")
    if probability is not None:
        first += f" and non-dominated on {per_cent(float(probability[row]))} of the resamples"
    return f"{first}. It {'satisfies every limit' if front.feasible[row] else 'violates a limit'} there.{behind}"


def _faults(results: TuningFolder, row: int) -> Sequence[str]:
    violated = "" if results.held_out_front.feasible[row] else "violates a limit"
    return [text for text in (violated, _lost(results, row)) if text]


def _lost(results: TuningFolder, row: int) -> str:
    front = results.held_out_front
    lost, flights = int(front.lost[row]), front.columns.get("flights")
    made = results.document.held_out if flights is None else int(flights[row])
    return f"{lost} of {made} held-out simulations failed" if lost else ""


def _column(entry: FinalistColumn, results: TuningFolder, row: int) -> str:
    """Return a cell; the default is none of the points with shares."""
    front = results.held_out_front
    value = entry.cell(front.columns, row)
    if entry.form == "share":
        return MISSING if front.roles[row] == DEFAULT else per_cent(value)
    return significant(value)


def _loop(loop: Loop, units: Sequence[tuple[str, float]]) -> list[str]:
    texts = []
    for name, (_, per_unit) in zip(LOOP_MARGINS, units, strict=True):
        value = loop.values.get(name)
        quantity = QUANTITIES[name]
        missing = quantity.infinite_text("∞") if loop.stable else MISSING
        texts.append(missing if value is None else significant(float(quantity.shown(value)) / per_unit, 3))
    return [loop.channel, "yes" if loop.stable else "no", *texts, loop.case or MISSING]


def margin_units(results: TuningFolder) -> list[tuple[str, float]]:
    """Return unit and scale of each margin of a loop."""
    return [time_unit(name, [loop.values.get(name) for loop in results.loops]) for name in LOOP_MARGINS]


def margin_heads(results: TuningFolder) -> list[tuple[str, str]]:
    """Return the headings of the margins of a loop, each with what it means."""
    entries = [QUANTITIES[name] for name in LOOP_MARGINS]
    units = [{"1": "", "deg": "°"}.get(unit, unit) for unit, _ in margin_units(results)]
    return [
        (f"{entry.label} [{unit}]" if unit else entry.label, entry.meaning)
        for entry, unit in zip(entries, units, strict=True)
    ]
