"""What a finished tuning run has to tell, as data; SI units and radians, as in summary.json."""

from pathlib import Path
from typing import Any

import numpy as np

from objectives.decisions import Variable as Range
from tuner.documents.finalists import FINALIST_COLUMNS
from tuner.documents.summary import VariableRow
from tuner.documents.tuning import TuningFolder

Row = dict[str, Any]


def tuning_story(folder: Path) -> tuple[Row, TuningFolder]:
    """Return the story of a folder and the results behind it; StoreError names a file that is missing or damaged."""
    results = TuningFolder(folder)
    summary = results.summary
    feasible = summary.recommends
    shown = {"point": summary.shown, **summary.pick.content()}
    return {
        "kind": "tuning",
        "finished": True,
        "feasible": feasible,
        "ending": summary.ending,
        "title": summary.title,
        "asked": asked(results),
        "recommended": shown if feasible else None,
        "nearest": None if feasible else shown,
        "shown_as": summary.shown_as,
        "confirmation_flights": summary.held_out,
        "table": [row.content() for row in summary.table],
        "gains": [gain(row) for row in summary.variables],
        "front": front(results),
        "trust": trust(results),
        "warnings": summary.warnings,
        "remarks": summary.remarks,
        "commands": commands(folder, summary.gains_file, feasible),
    }, results


def asked(results: TuningFolder) -> Row:
    """Return what was asked and what it took."""
    resolved, summary = results.resolved, results.summary
    return {
        "airframe": resolved.airframe.name,
        "laws": {"position": resolved.controller.position, "attitude": resolved.controller.attitude},
        "seed": resolved.seed,
        "searched": [variable.name for variable in results.variables],
        "objectives": [entry.label for entry in results.objectives],
        "algorithm": resolved.search.algorithm,
        "candidates": len(results.candidates.number),
        "flights": summary.flights,
        "wall_seconds": summary.wall_seconds,
    }


def gain(row: VariableRow) -> Row:
    """Return a searched gain with the places of default and tuned value in its range, 0 to 1 on the range's own scale."""
    span = Range(row.name, (), row.low, row.high, row.scale)
    known = row.model_dump(include={"name", "unit", "low", "high", "scale", "default", "tuned"})
    return {**known, "default_place": span.unit(row.default), "place": span.unit(row.tuned)}


def front(results: TuningFolder) -> list[Row]:
    """Return default and held-out front: values with intervals by objective, probability of being on the front."""
    found = results.front
    shown = [
        i
        for i in np.argsort(found.held_out[:, 0], kind="stable")
        if found.roles[i] or (found.non_dominated[i] and found.feasible[i])
    ]
    rows = []
    for i in shown:
        ends = [found.stored[name][i].tolist() for name in ("held_out", "low", "high")]
        values = {
            entry.label: {"value": value, "low": low, "high": high}
            for entry, value, low, high in zip(results.objectives, *ends, strict=True)
        }
        told = {entry.name: entry.cell(found.columns, i) for entry in FINALIST_COLUMNS if entry.form != "flag"}
        rows.append({"point": found.points[i], "role": found.roles[i], **told, "values": values})
    return rows


def trust(results: TuningFolder) -> Row:
    """Return how the recommended point did in the search and held out, and how the search ended."""
    history, summary = results.history, results.summary
    return {
        "picked_on": summary.picked_on and summary.picked_on.content(),
        "front_size": summary.front_size,
        "generations": len(history.generation),
        "hypervolume": float(history.hypervolume[-1]),
        "feasible_share": float(history.feasible_share[-1]),
    }


def commands(folder: Path, file: str, feasible: bool) -> list[str]:
    """Return what to do next; gains that break limits are looked at and not flown."""
    gains = folder / file
    if not feasible:
        return [f"tuner margins {gains}", f"tuner check {folder / 'study.toml'}", f"tuner report {folder}"]
    return [f"tuner fly {gains} --plot fly.png", f"tuner margins {gains}", f"tuner report {folder}"]
