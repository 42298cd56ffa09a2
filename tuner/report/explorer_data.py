"""The data of the page that its scripts draw: everything in it is a number or a text of the results folder.

    tuned, called                      name of the recommended point, or of the one nearest to feasible, and what it is called
    gains_file, gains_name             gains.json, or infeasible.json, as it stands in the folder, and its name
    held_out                           held-out flights of each point
    objectives, variables              dimensions of the explorer: label or name, unit, definition, range shown
    constraints, requirements          what is limited: label, unit, factor, limit as stored
    points                             default and finalists: values as stored, `factor` of their quantity makes shown units
    candidates                         what the search tried beside them: number, state, values, packed
    responses, loops                   see `packed_responses` and `packed_loops`, null where the folder holds none
    history                            progress by generation

States of candidates: 0 breaks a limit, 1 feasible, 2 the design start.
"""

from typing import Any

import numpy as np

from objectives.scales import DECIBEL
from tuner.documents.results import Quantity, Required, Results, Variable
from tuner.report.front_ranges import shown_range
from tuner.report.outcome_table import risk_text
from tuner.report.packed_loops import packed_loops
from tuner.report.packed_responses import packed_responses
from tuner.report.packing import base64, finite, singles
from tuner.text.units import plain

# Candidates kept at most; beyond, they are thinned evenly.
MOST_CANDIDATES = 20000
INFEASIBLE, SEARCHED, START = 0, 1, 2


def explorer_data(results: Results) -> dict[str, Any]:
    """Return the document; no number in it is NaN or infinite."""
    return {
        "tuned": results.tuned,
        "called": results.called,
        "gains_file": results.gains_text,
        "gains_name": results.gains_name,
        "held_out": results.summary["held_out"],
        "objectives": [_objective(results, i) for i in range(len(results.objectives))],
        "variables": [_variable(entry, results.addresses[entry.name]) for entry in results.variables],
        "constraints": [_limited(entry, entry.limit) for entry in results.constraints],
        "requirements": [_required(entry) for entry in results.requirements],
        "points": [_point(results, row) for row in range(len(results.front.points))],
        "candidates": _candidates(results),
        "responses": packed_responses(results),
        "loops": packed_loops(results),
        "history": {name: finite(values) for name, values in results.history.series().items()},
    }


def definition_text(quantity: Quantity) -> str:
    """Return what a quantity measures, and over which flights."""
    where = "all scenarios" if quantity.scenario is None else f"scenario {quantity.scenario}"
    return f"{quantity.definition}; {risk_text(quantity)}, {where}".replace("`", "")


def _objective(results: Results, i: int) -> dict[str, Any]:
    entry, shown = results.objectives[i], shown_range(results.front, i)
    return {**_limited(entry, None), "low": shown.low, "high": shown.high, "log": shown.log}


def _limited(entry: Quantity, limit: float | None) -> dict[str, Any]:
    return {
        "label": entry.label,
        "definition": definition_text(entry),
        "unit": plain(entry.unit),
        "factor": entry.factor,
        "limit": None if limit is None else limit / entry.factor,
    }


def _required(entry: Required) -> dict[str, Any]:
    factor = entry.factor
    about = {"label": entry.label, "definition": entry.quantity, "unit": plain(entry.unit), "factor": factor}
    limit = DECIBEL.si(entry.limit) if entry.decibel else entry.limit / factor
    return {**about, "decibel": entry.decibel, "limit": limit, "sense": entry.sense}


def _variable(entry: Variable, addresses: list[str]) -> dict[str, Any]:
    return {
        "name": entry.name,
        "meaning": entry.meaning,
        "unit": plain("" if entry.unit == "1" else entry.unit),
        "written": entry.unit,
        "low": entry.low,
        "high": entry.high,
        "log": entry.scale == "log",
        "default": entry.default,
        "addresses": addresses,
    }


def _point(results: Results, row: int) -> dict[str, Any]:
    front = results.front
    probability = None if front.probability is None else front.probability[[row]]
    limited = {name: results.limited.get((front.points[row], name)) for name in (c.label for c in results.constraints)}
    return {
        "name": front.points[row],
        "role": front.roles[row],
        "front": bool(front.non_dominated[row]),
        "feasible": bool(front.feasible[row]),
        "lost": int(front.lost[row]),
        "probability": None if probability is None else finite(probability)[0],
        "gains": finite(front.gains[row]),
        **{name: finite(values[row]) for name, values in front.stored.items()},
        "requirements": finite(front.requirements[row]),
        "constraints": [None if values is None else finite(values) for values in limited.values()],
    }


def _candidates(results: Results) -> dict[str, Any]:
    tried, front = results.candidates, results.front
    flown = front.candidates[[role != "default" for role in front.roles]]
    rows = thinned(np.flatnonzero(~(tried.feasible & np.isin(tried.number, flown))), MOST_CANDIDATES)
    state = np.where(tried.feasible[rows], SEARCHED, INFEASIBLE)
    state[tried.number[rows] == results.start] = START
    factors = np.array([entry.factor for entry in results.objectives])
    values = np.concatenate([tried.values[rows] / factors, tried.gains[rows]], axis=1)
    return {
        "count": len(rows),
        "start": bool((state == START).any()),
        "number": base64(tried.number[rows], "<u4"),
        "state": base64(state, "u1"),
        "values": [singles(column) for column in values.T],
    }


def thinned(rows: np.ndarray, most: int) -> np.ndarray:
    """Return at most so many of the rows, evenly spread."""
    if len(rows) <= most:
        return rows
    return rows[np.linspace(0, len(rows) - 1, most).round().astype(int)]
