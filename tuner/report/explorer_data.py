"""The data of a tuning page that its scripts use: everything in it is a number or a text of the results folder.

    tuned                              name of the recommended point, or of the one nearest to feasible
    gains_file, gains_name             gains.json, or infeasible.json, as it stands in the folder, and its name
    objectives, variables, limits      dimensions of the explorer: label or name, unit, definition, range shown, limit and sense
    quantities, margins                rows and headings of the tables of a point, see `point_texts`; margins: null without loops
    columns                            numbers of every finalist that have a column: name, form, heading, meaning
    points                             default and finalists: name, title in words, objectives as shown with their ends, gains,
                                       limited quantities, `texts`, and what differs in their gains files (`patch`)
    states                             what a point of each layer is
    candidates                         what the search tried next to them: number, state, values as of points, packed
    layers, pins                       how the points and pins look: label, marker and line of plotly.js
    responses                          {scenarios, flights: {SCENARIO: {POINT: number of its worst flight}}}, or null
    charts, arrays                     see `charts.web`

States of candidates: 0 breaks a limit, 1 feasible, 2 the design start.
"""

import numpy as np
from pydantic import JsonValue

from tuner.documents.finalists import FINALIST_COLUMNS
from tuner.documents.parts import numbers_on_page, on_page
from tuner.documents.summary import TableRow, VariableRow
from tuner.documents.tuning import SHOWN, TuningFolder
from tuner.report.charts.chart import span_of
from tuner.report.charts.front import LAYERS, LOG_FACTOR, shown_range, shown_rows
from tuner.report.charts.look import PINS
from tuner.report.charts.web import Arrays, WebPanel, finite, line_of, marker_of, packed, singles
from tuner.report.gains_section import place_of
from tuner.report.labels import definition_text, named, titles_of
from tuner.report.point_texts import STATES, margin_heads, patch, point_texts, quantity_texts
from tuner.report.tuning_charts import kept_points
from tuner.text.numbers import MISSING, significant
from tuner.text.units import plain

# Candidates kept at most; beyond, they are thinned evenly.
MAX_CANDIDATES = 6000
INFEASIBLE, SEARCHED, START = 0, 1, 2
LimitedQuantities = tuple[list[TableRow], np.ndarray]
"""Limited quantities that differ among finalists, and their values (finalists, quantities)."""


def explorer_data(
    results: TuningFolder, limited: LimitedQuantities, charts: dict[str, WebPanel], arrays: Arrays
) -> dict[str, object]:
    """Return the document; no number in it is NaN or infinite."""
    limits, values = limited
    return {
        "tuned": results.tuned,
        "gains_file": results.gains_text,
        "gains_name": results.document.gains_file,
        "objectives": [_objective(results, i) for i in range(len(results.objectives))],
        "variables": [_variable(entry, results.addresses[entry.name]) for entry in results.variables],
        "limits": [_limit(results, row, values[:, i]) for i, row in enumerate(limits)],
        "quantities": quantity_texts(results),
        "columns": [entry.about for entry in FINALIST_COLUMNS if entry.heading],
        "points": [_point(results, row, values[row]) for row in range(len(results.held_out_front.points))],
        "candidates": _candidates(results, limits),
        "layers": _layers(results),
        "pins": [{"marker": marker_of(look), "line": line_of(look)} for look in PINS],
        "margins": margin_heads(results) if results.loops else None,
        "states": {**STATES, "tuned": results.called},
        "responses": _responses(results),
        "charts": charts,
        "arrays": arrays.packed,
    }


def _objective(results: TuningFolder, i: int) -> dict[str, JsonValue]:
    entry, shown = results.objectives[i], shown_range(results.held_out_front, i)
    return {**_about(results, entry), "low": shown.low, "high": shown.high, "log": shown.log}


def _limit(results: TuningFolder, entry: TableRow, values: np.ndarray) -> dict[str, JsonValue]:
    shown = span_of([values[shown_rows(results.held_out_front)], np.array([entry.limit])], LOG_FACTOR, 0.07)
    about = {**_about(results, entry), "sense": entry.sense, "limit": entry.limit}
    return {**about, "low": shown.low, "high": shown.high, "log": shown.log}


def _about(results: TuningFolder, entry: TableRow) -> dict[str, JsonValue]:
    return {
        "label": named(results, entry, short=True),
        "definition": definition_text(entry),
        "unit": plain(entry.unit),
    }


def limited_quantities(results: TuningFolder) -> LimitedQuantities:
    """Return limited quantities that differ among finalists, and their values (finalists, quantities).

    NaN: infinite, as a margin that no crossing limits, or not known.
    """
    tables = [results.rows_of(row) for row in range(len(results.held_out_front.points))]
    rows = [[on_page(entry, *SHOWN) for entry in table if entry.limit is not None] for table in tables]
    values = np.array([[entry.tuned.value for entry in row] for row in rows], dtype=float).reshape(len(rows), -1)
    differ = [len(np.unique(column[np.isfinite(column)])) > 1 for column in values.T]
    return [entry for entry, differs in zip(rows[0], differ, strict=True) if differs], values[:, differ]


def _variable(entry: VariableRow, addresses: list[str]) -> dict[str, JsonValue]:
    return {
        "name": entry.name,
        "meaning": entry.meaning,
        "unit": plain("" if entry.unit == "1" else entry.unit),
        "written": MISSING if entry.unit == "1" else entry.unit,
        "low": entry.low,
        "high": entry.high,
        "log": entry.scale == "log",
        "shown": significant(entry.default),
        "place": place_of(entry, entry.default),
        "ends": [significant(entry.low), entry.scale, significant(entry.high)],
        "addresses": list(addresses),
    }


def _point(results: TuningFolder, row: int, limited: np.ndarray) -> dict[str, object]:
    front = results.held_out_front
    numbers = {"held_out": front.held_out, "low": front.low, "high": front.high, "gains": front.gains}
    return {
        "name": front.points[row],
        "title": titles_of(results)[front.points[row]],
        "role": front.roles[row],
        "front": bool(front.non_dominated[row]),
        **{entry.name: entry.cell(front.columns, row) for entry in FINALIST_COLUMNS},
        **{name: finite(values[row]) for name, values in numbers.items()},
        "limited": finite(limited),
        "texts": point_texts(results, row),
        "patch": [patch(entry) for entry in results.rows_of(row)],
    }


def _candidates(results: TuningFolder, limits: list[TableRow]) -> dict[str, object]:
    tried, front = results.evaluated, results.held_out_front
    flown = front.candidates[[role != "default" for role in front.roles]]
    rows = thinned(np.flatnonzero(~(tried.feasible & np.isin(tried.number, flown))), MAX_CANDIDATES)
    state = np.where(tried.feasible[rows], SEARCHED, INFEASIBLE)
    state[tried.number[rows] == results.start] = START
    values = np.concatenate([tried.values[rows], tried.gains[rows], _limited(results, limits)[rows]], axis=1)
    return {
        "count": len(rows),
        "start": bool((state == START).any()),
        "number": packed(tried.number[rows], "<u4"),
        "state": packed(state, "u1"),
        "values": [singles(column) for column in values.T],
    }


def _limited(results: TuningFolder, limits: list[TableRow]) -> np.ndarray:
    """Return the limited quantities (candidates, limits) as shown; NaN: limits on flights, which are not recorded."""
    tried = results.evaluated
    required = {entry.label: i for i, entry in enumerate(results.document.required)}
    out = np.full((len(tried.number), len(limits)), np.nan)
    for k, entry in enumerate(limits):
        if entry.kind == "requirement":
            i = required[entry.label]
            out[:, k] = numbers_on_page(results.document.required[i], tried.requirements[:, i])
    return out


def thinned(rows: np.ndarray, most: int) -> np.ndarray:
    """Return at most so many of the rows, evenly spread."""
    if len(rows) <= most:
        return rows
    return rows[np.linspace(0, len(rows) - 1, most).round().astype(int)]


def _layers(results: TuningFolder) -> dict[str, object]:
    return {
        key: {
            "label": results.called if key == "tuned" else label,
            "marker": marker_of(look),
            "line": line_of(look, 1.0),
        }
        for key, (label, look) in LAYERS.items()
    }


def _responses(results: TuningFolder) -> dict[str, object] | None:
    if not results.fans:
        return None
    points = kept_points(results)
    flights: dict[str, dict[str, int | None]] = {name: {} for name in results.scenarios}
    for fan in results.fans:
        if fan.point in points:
            flights[fan.scenario][fan.point] = fan.flight
    return {"scenarios": results.scenarios, "flights": flights}
