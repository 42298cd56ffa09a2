"""What the vehicles and the air did in a contest: fans over flights, flight 0 of every scenario, and its air."""

from typing import Any

import numpy as np

from plant.scenarios import WIND_COLUMNS, sample_scenarios
from tuner.analysis.responses import SIGNALS, UNITS, Responses, fan_table, fly_responses
from tuner.experiments.contest.result import Result
from tuner.experiments.tuning.tables import FAN_SCENARIOS
from tuner.store.folder import data_frame, stacked

# Columns of the air in the order of `plant.air.air`, with units; world is ENU, body is FLU.
AIR = tuple(
    (f"{name}_{axis}", unit)
    for name, unit in (("wind", "m/s"), ("gust_rate", "rad/s"), ("acceleration", "m/s^2"), ("angular_acceleration", "rad/s^2"))
    for axis in "xyz"
)  # fmt: skip
# Instants of the air of flight 0; more do not show.
AIR_INSTANTS = 2000


def response_tables(result: Result) -> tuple[Any, Any]:
    """Fly every contender again with a recorder on; return the fans over flights and the traces of flight 0."""
    contest, fans, traces = result.contest, [], []
    for scenario in contest.scenarios:
        count = min(FAN_SCENARIOS, scenario.held_out)
        for entry in result.entries:
            system = entry.problem.system
            inputs = sample_scenarios(
                scenario.spec, system.vehicle, system.timing, contest.seed, contest.stream, range(count)
            )
            flown = fly_responses(entry.problem.flyer, entry.row, system.nominal, inputs, system.timing.control_period)
            fans.append(fan_table(flown, entry.contender.name, scenario.spec.name))
            traces.append(trace_table(flown, entry.contender.name, scenario.spec.name))
    return stacked(fans), stacked(traces)


def trace_table(flown: Responses, contender: str, scenario: str) -> Any:
    """Return flight 0 as a long table: one row for each signal and instant."""
    return stacked(
        [
            data_frame(
                {
                    "contender": contender, "scenario": scenario, "flight": 0, "signal": signal, "unit": unit,
                    "time": flown.time, "value": flown.actual[0, :, i], "reference": flown.reference[0, :, i],
                }
            )
            for i, (signal, unit) in enumerate(zip(SIGNALS, UNITS, strict=True))
        ],
    )  # fmt: skip


def wind_table(result: Result) -> Any:
    """Return the air of flight 0 of every scenario as a long table; columns of the air that are zero throughout are left out,
    but the wind stays.
    """
    contest, system = result.contest, result.contest.base.system
    parts = []
    for scenario in contest.scenarios:
        drawn = sample_scenarios(scenario.spec, system.vehicle, system.timing, contest.seed, contest.stream, range(1))
        air = drawn.disturbances[0, :, :, 0]
        every = -(-len(air) // AIR_INSTANTS)
        time = np.arange(0, len(air), every) * system.timing.control_period
        for column in range(air.shape[1]):
            if column < WIND_COLUMNS or air[:, column].any():
                signal, unit = AIR[column]
                parts.append(
                    data_frame(
                        {
                            "scenario": scenario.spec.name, "flight": 0, "signal": signal, "unit": unit, "time": time,
                            "value": air[::every, column],
                        }
                    )
                )  # fmt: skip
    return stacked(parts)
