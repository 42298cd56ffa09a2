"""The data of a tuning page that its scripts use: everything in it is a number or a text of the results folder.

    tuned, called                      name of the recommended point, or of the one nearest to feasible, and what it is called
    gains_file, gains_name             gains.json, or infeasible.json, as it stands in the folder, and its name
    held_out                           held-out flights of each point
    objectives, variables              dimensions of the explorer: label or name, unit, definition, range shown
    constraints, requirements          what is limited: label, unit, factor, limit as stored
    columns                            numbers of every finalist that have a column: name, form, heading, meaning
    points                             default and finalists: values as stored, `factor` of their quantity makes shown units
    candidates                         what the search tried beside them: number, state, values, packed
    layers                             how the points look: label, marker and line of plotly.js
    margins                            {quantities, channels, points: {POINT: [{channel, stable, values, case}]}}, or null
    responses                          {scenarios, flights: {SCENARIO: {POINT: number of its worst flight}}}, or null
    charts, arrays                     see `charts.web`

States of candidates: 0 breaks a limit, 1 feasible, 2 the design start.
"""

from typing import Any

import numpy as np

from objectives.margins.quantities import QUANTITIES
from objectives.scales import DECIBEL
from tuner.documents.finalists import FINALIST_COLUMNS
from tuner.documents.parts import is_level
from tuner.documents.summary import ComparedRow, RequiredRow, VariableRow
from tuner.documents.tuning import LOOP_MARGINS, Loop, TuningFolder
from tuner.report.answer_section import definition_text
from tuner.report.charts.front import LAYERS, shown_range
from tuner.report.charts.web import Arrays, finite, line_of, marker_of, packed, singles
from tuner.report.tuning_charts import kept_points
from tuner.text.units import in_degrees, plain

# Candidates kept at most; beyond, they are thinned evenly.
MOST_CANDIDATES = 6000
INFEASIBLE, SEARCHED, START = 0, 1, 2


def explorer_data(results: TuningFolder, charts: dict[str, Any], arrays: Arrays) -> dict[str, Any]:
    """Return the document; no number in it is NaN or infinite."""
    return {
        "tuned": results.tuned,
        "called": results.called,
        "gains_file": results.gains_text,
        "gains_name": results.summary.gains_file,
        "held_out": results.summary.held_out,
        "objectives": [_objective(results, i) for i in range(len(results.objectives))],
        "variables": [_variable(entry, results.addresses[entry.name]) for entry in results.variables],
        "constraints": [_limited(entry) for entry in results.summary.compared if entry.kind == "constraint"],
        "requirements": [_required(entry) for entry in results.summary.required],
        "columns": [entry.about for entry in FINALIST_COLUMNS if entry.heading],
        "points": [_point(results, row) for row in range(len(results.front.points))],
        "candidates": _candidates(results),
        "layers": _layers(results),
        "margins": _margins(results),
        "responses": _responses(results),
        "charts": charts,
        "arrays": arrays.packed,
    }


def _objective(results: TuningFolder, i: int) -> dict[str, Any]:
    entry = [row for row in results.summary.compared if row.kind == "objective"][i]
    shown = shown_range(results.front, i)
    return {**_limited(entry), "low": shown.low, "high": shown.high, "log": shown.log}


def _limited(stored: ComparedRow) -> dict[str, Any]:
    unit, factor = in_degrees(stored.unit)
    return {
        "label": stored.label,
        "definition": definition_text(stored),
        "unit": plain(unit),
        "factor": factor,
        "limit": stored.limit,
    }


def _required(stored: RequiredRow) -> dict[str, Any]:
    decibel, (unit, factor) = is_level(stored), in_degrees(stored.unit)
    return {
        "label": stored.label,
        "definition": stored.quantity,
        "unit": DECIBEL.unit if decibel else plain(unit),
        "factor": factor,
        "decibel": decibel,
        "limit": stored.limit,
        "sense": stored.sense,
    }


def _variable(entry: VariableRow, addresses: list[str]) -> dict[str, Any]:
    return {
        "name": entry.name,
        "meaning": entry.meaning,
        "unit": plain("" if entry.unit == "1" else entry.unit),
        "written": entry.unit,
        "low": entry.low,
        "high": entry.high,
        "log": entry.scale == "log",
        "default": entry.default,
        "fixed_ends": list(entry.natural_ends),
        "addresses": addresses,
    }


def _point(results: TuningFolder, row: int) -> dict[str, Any]:
    front = results.front
    limited = {name: results.limited.get((front.points[row], name)) for name in (c.label for c in results.constraints)}
    return {
        "name": front.points[row],
        "role": front.roles[row],
        "front": bool(front.non_dominated[row]),
        **{entry.name: entry.cell(front.columns, row) for entry in FINALIST_COLUMNS},
        "gains": finite(front.gains[row]),
        **{name: finite(values[row]) for name, values in front.stored.items()},
        "requirements": finite(front.requirements[row]),
        "constraints": [None if values is None else finite(values) for values in limited.values()],
    }


def _candidates(results: TuningFolder) -> dict[str, Any]:
    tried, front = results.candidates, results.front
    flown = front.candidates[[role != "default" for role in front.roles]]
    rows = thinned(np.flatnonzero(~(tried.feasible & np.isin(tried.number, flown))), MOST_CANDIDATES)
    state = np.where(tried.feasible[rows], SEARCHED, INFEASIBLE)
    state[tried.number[rows] == results.start] = START
    values = np.concatenate([tried.values[rows] / results.factors, tried.gains[rows]], axis=1)
    return {
        "count": len(rows),
        "start": bool((state == START).any()),
        "number": packed(tried.number[rows], "<u4"),
        "state": packed(state, "u1"),
        "values": [singles(column) for column in values.T],
    }


def thinned(rows: np.ndarray, most: int) -> np.ndarray:
    """Return at most so many of the rows, evenly spread."""
    if len(rows) <= most:
        return rows
    return rows[np.linspace(0, len(rows) - 1, most).round().astype(int)]


def _layers(results: TuningFolder) -> dict[str, Any]:
    return {
        key: {
            "label": results.called if key == "tuned" else label,
            "marker": marker_of(look),
            "line": line_of(look, 1.0),
        }
        for key, (label, look) in LAYERS.items()
    }


def _margins(results: TuningFolder) -> dict[str, Any] | None:
    if not results.loops:
        return None
    points: dict[str, list[dict[str, Any]]] = {}
    for loop in results.loops:
        points.setdefault(loop.point, []).append(_loop(loop))
    quantities = [_quantity(name) for name in LOOP_MARGINS]
    return {"quantities": quantities, "channels": channels(results), "points": points}


def _quantity(name: str) -> dict[str, Any]:
    """Return how the page shows a margin quantity: in dB, or by a factor."""
    entry = QUANTITIES[name]
    decibel = entry.scale is DECIBEL
    unit = {"1": "", "deg": "°"}.get(entry.shown_unit, entry.shown_unit)
    factor = 1.0 if decibel else float(entry.shown(1.0))
    about = {"unit": unit, "factor": factor, "decibel": decibel, "meaning": entry.meaning}
    return {"name": name, "label": entry.label, **about}


def channels(results: TuningFolder) -> list[str]:
    """Return the names of the loops that the folder holds."""
    return list(dict.fromkeys(loop.channel for loop in results.loops))


def _loop(loop: Loop) -> dict[str, Any]:
    values = {name: loop.values.get(name) for name in LOOP_MARGINS}
    return {"channel": loop.channel, "stable": loop.stable, "case": loop.case, "values": values}


def _responses(results: TuningFolder) -> dict[str, Any] | None:
    if not results.fans:
        return None
    points = kept_points(results)
    flights: dict[str, dict[str, int | None]] = {name: {} for name in results.scenarios}
    for fan in results.fans:
        if fan.point in points:
            flights[fan.scenario][fan.point] = fan.flight
    return {"scenarios": results.scenarios, "flights": flights}
