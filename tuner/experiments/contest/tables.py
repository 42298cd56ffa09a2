"""The tables of a contest's folder; columns are told in results/README.md."""

from collections.abc import Sequence
from typing import Any

from plant.gains import gain_addresses
from tuner.experiments.contest.result import Result
from tuner.store.document import DocumentPart
from tuner.store.folder import data_frame, stacked


def scores_table(result: Result) -> Any:
    """Return every score of every flight, long: contender, quantity, scenario, flight (index in its scenario), value."""
    parts = []
    first = {entry.spec.name: 0 for entry in result.contest.scenarios}
    origin = result.flown.origin
    for name in first:
        first[name] = int((origin == name).argmax(axis=0))
    for k, contender in enumerate(result.names):
        for i, quantity in enumerate(result.contest.quantities):
            wanted = quantity.objective.scenario
            seen = [n for n in range(len(origin)) if wanted in (None, origin[n])]
            parts.append(
                data_frame(
                    {
                        "contender": contender, "quantity": quantity.label, "scenario": origin[seen],
                        "flight": [n - first[origin[n]] for n in seen], "value": result.flown.scores[k, i, seen],
                    }
                )
            )  # fmt: skip
    return stacked(parts)


def fronts_table(result: Result) -> Any:
    """Return the points of all fronts; a gain that a contender's laws have not, or a value not picked by, is empty."""
    rows = []
    objectives = result.contest.base.objectives
    for own, name, front in zip(result.prepared, result.names, result.fronts, strict=True):
        known = gain_addresses(own.contender.study.system.cascade)
        for n, point in enumerate(front.points):
            row: dict[str, Any] = {
                "contender": name, "point": point, "candidate": int(front.candidates[n]),
                "recommended": point == own.entry.point, "lost": int(front.lost[n]),
            }  # fmt: skip
            for i, objective in enumerate(objectives):
                row |= {f"value:{objective.label}": front.values[n, i]}
                row |= {f"low:{objective.label}": front.low[n, i], f"high:{objective.label}": front.high[n, i]}
            if front.picked is not None:
                row |= {f"picked_on:{o.label}": front.picked[n, i] for i, o in enumerate(objectives)}
            row |= {f"gain:{gain.address}": front.gains[n, gain.column] for gain in known}
            rows.append(row)
    return data_frame(rows)


def listed_table(rows: Sequence[DocumentPart]) -> Any:
    """Return a list of contest.json as a table; a list inside stands with semicolons."""
    content = [row.content() for row in rows]
    return data_frame([{k: "; ".join(v) if isinstance(v, list) else v for k, v in row.items()} for row in content])
