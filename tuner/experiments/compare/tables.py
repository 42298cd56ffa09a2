"""The tables of a comparison's folder; results/README.md lists the columns.

Scores and fronts, and what the vehicles and the air did: fans over flights, flight 0 of every scenario, and its air.
"""

from collections.abc import Sequence

import numpy as np

from tuner.analysis.responses import Responses, fan_table, responses_of
from tuner.experiments.compare.result import Result
from tuner.experiments.tuning.fans import FAN_SCENARIOS
from tuner.store.columns import Columns, columns_of, stacked
from tuner.store.document import DocumentPart


def scores_table(result: Result) -> Columns:
    """Return every score of every flight, long: contender, quantity, scenario, flight (index in its scenario), value."""
    parts = []
    first = {entry.spec.name: 0 for entry in result.study.scenarios}
    origin = result.flown.origin
    for name in first:
        first[name] = int((origin == name).argmax(axis=0))
    for k, contender in enumerate(result.names):
        for i, quantity in enumerate(result.study.quantities):
            wanted = quantity.objective.scenario
            seen = [n for n in range(len(origin)) if wanted in (None, origin[n])]
            parts.append(
                {
                    "contender": contender,
                    "quantity": quantity.label,
                    "scenario": origin[seen],
                    "flight": [n - first[origin[n]] for n in seen],
                    "value": result.flown.scores[k, i, seen],
                }
            )
    return stacked(parts)


def fronts_table(result: Result) -> Columns:
    """Return the points of all fronts; a gain that a contender's laws have not, or a value not picked by, is empty."""
    rows = []
    objectives = result.study.base.objectives
    for entrant, name, front in zip(result.prepared, result.names, result.fronts, strict=True):
        gains_of = entrant.contender.study.system.gains
        for n, point in enumerate(front.points):
            row: dict[str, str | bool | float] = {
                "contender": name,
                "point": point,
                "candidate": int(front.candidates[n]),
                "recommended": point == entrant.entry.point,
                "lost": int(front.lost[n]),
            }
            for i, objective in enumerate(objectives):
                row |= {f"value:{objective.label}": front.values[n, i]}
                row |= {f"low:{objective.label}": front.low[n, i], f"high:{objective.label}": front.high[n, i]}
            if front.picked is not None:
                row |= {f"picked_on:{o.label}": front.picked[n, i] for i, o in enumerate(objectives)}
            row |= {f"gain:{gain.address}": front.gains[n, gain.column] for gain in gains_of}
            rows.append(row)
    return columns_of(rows)


def listed_table(rows: Sequence[DocumentPart]) -> Columns:
    """Return a list of study.json as a table; a list inside stands with semicolons."""
    content = [row.content() for row in rows]
    return columns_of([{k: "; ".join(v) if isinstance(v, list) else v for k, v in row.items()} for row in content])


# Instants of the air of flight 0; more do not show.
AIR_INSTANTS = 2000


def response_tables(result: Result) -> tuple[Columns, Columns]:
    """Fly every contender again with a recorder on; return the fans over flights and the traces of flight 0."""
    study, fans, traces = result.study, [], []
    for scenario in study.scenarios:
        count = min(FAN_SCENARIOS, scenario.held_out)
        for entry in result.entries:
            system = entry.problem.system
            inputs = system.sample(scenario.spec, study.seed, study.stream, range(count))
            flown = responses_of(system, entry.problem.flyer, entry.row, inputs)
            fans.append(fan_table(flown, entry.contender.name, scenario.spec.name))
            traces.append(trace_table(flown, entry.contender.name, scenario.spec.name))
    return stacked(fans), stacked(traces)


def trace_table(flown: Responses, contender: str, scenario: str) -> Columns:
    """Return flight 0 as a long table: one row for each signal and instant."""
    return stacked(
        [
            {
                "contender": contender,
                "scenario": scenario,
                "flight": 0,
                "signal": signal,
                "unit": unit,
                "time": flown.time,
                "value": flown.actual[0, :, i],
                "reference": flown.reference[0, :, i],
            }
            for i, (signal, unit) in enumerate(zip(flown.signals, flown.units, strict=True))
        ],
    )


def wind_table(result: Result) -> Columns | None:
    """Return the air or disturbance of flight 0 in every scenario.

    A long table. Columns that are zero throughout are left out, but the wind stays. None for a plant that nothing acts
    on.
    """
    study, system = result.study, result.study.base.system
    names, shown, parts = list(system.disturbances.items()), system.loop.records.n_wind_leaves, []
    for scenario in study.scenarios:
        drawn = system.sample(scenario.spec, study.seed, study.stream, range(1))
        air = drawn.disturbances[0, :, :, 0]
        every = -(-len(air) // AIR_INSTANTS)
        time = np.arange(0, len(air), every) * system.timing.control_period
        for column in range(air.shape[1]):
            if column < shown or air[:, column].any():
                signal, unit = names[column]
                parts.append(
                    {
                        "scenario": scenario.spec.name,
                        "flight": 0,
                        "signal": signal,
                        "unit": unit,
                        "time": time,
                        "value": air[::every, column],
                    }
                )
    return stacked(parts) if parts else None
