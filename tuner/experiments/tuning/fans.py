"""Fans of responses: every finalist over many held-out flights, and in the one in which it did worst.

The worst is the one with the largest value of the first objective that counts in the scenario.
The flights of a fan are the first that every finalist makes held out, so they are recorded while they are made. If they were
not, because they were on record or flown elsewhere or in several ranges, they are flown again, with the same bits.
"""

from typing import Any, NamedTuple

import numpy as np

from objectives.flown_system import FlightBatch
from objectives.problem import Problem
from plant.backends.flyer import Recording
from plant.quadrotor.scenarios import HELD_OUT, ScenarioSpec
from plant.threads import parallel_map
from plant.ties import first_largest
from tuner.analysis.responses import Responses, responses_from, responses_of, spacing, traced_rows
from tuner.experiments.tuning.outcome import FlightOutcome, Outcome
from tuner.store.columns import Columns, in_codes, stacked
from tuner.study.study import SearchedStudy, TuningStudy

# Held-out scenarios a fan is drawn from: its 5 % and 95 % lines rest on three flights each.
FAN_SCENARIOS = 64


class PointFan(NamedTuple):
    """Responses of a point over many flights: time (instants,) [s]; else (instants, signals), worst: in its worst flight.

    signals, units: names and units of the last axis; worst_flight: index of that flight among the held-out ones.
    """

    time: np.ndarray
    reference: np.ndarray
    low: np.ndarray
    median: np.ndarray
    high: np.ndarray
    worst: np.ndarray
    signals: tuple[str, ...]
    units: tuple[str, ...]
    worst_flight: int


SERIES = PointFan._fields[1:6]
"""Names of the numbers of each instant and signal."""


def fan_of(flown: Responses, worst: int) -> PointFan:
    """Return the fan of some flights; worst: index of the one that is shown by itself."""
    low, median, high = flown.fans()
    reference, shown = flown.reference.mean(axis=0), flown.actual[worst]
    return PointFan(flown.time, reference, low, median, high, shown, flown.signals, flown.units, worst)


class Fans:
    """Fans of a study's finalists, recorded while they make their held-out flights."""

    def __init__(self, study: TuningStudy, problem: Problem) -> None:
        self._study, self._problem = study, problem
        self._fans: dict[tuple[str, bytes], PointFan] = {}

    def record(self) -> None:
        """Record from now on."""
        for entry in self._study.scenarios:
            batch = FlightBatch(entry.spec, HELD_OUT, entry.held_out)
            self._problem.engine.record(batch, self._recording(entry.spec, fan_flights(entry)))

    def of(self, gains: np.ndarray, scenario: str) -> PointFan | None:
        """Return the recorded fan of gains (g,) in a scenario, or None."""
        return self._fans.get((scenario, gains.tobytes()))

    def _recording(self, spec: ScenarioSpec, flights: int) -> Recording:
        system, judge = self._problem.system, judging_objective(self._study, spec.name)

        def take(gains: np.ndarray, trace: np.ndarray, results: np.ndarray, references: np.ndarray) -> None:
            scores, _ = self._problem.score(results[None], spec)
            worst = first_largest(scores[0, judge])
            self._fans[spec.name, gains.tobytes()] = fan_of(responses_from(system, trace, references), worst)

        return Recording(flights, traced_rows(system), spacing(spec.steps(system.timing)), take)


def fan_flights(entry: Any) -> int:
    """Return the number of held-out flights behind a scenario's fans."""
    return min(FAN_SCENARIOS, entry.held_out)


def response_table(outcome: FlightOutcome, fans: Fans | None = None) -> Columns:
    """Return every finalist's fans over held-out flights as a long table.

    A row for each signal and instant: point, scenario, signal, unit, time [s], reference, low, median, high (5, 50, 95
    %), worst, and worst_flight, the index of that flight among the held-out ones. Values are float32: 31 points take 3
    MB a scenario. fans: those recorded, the others are flown.
    """
    table = stacked(
        point_table(fan, name, entry.spec.name)
        for entry in outcome.study.scenarios
        for fan, name in zip(scenario_fans(outcome, entry.spec, fan_flights(entry), fans), outcome.names, strict=True)
    )
    return table | {name: in_codes(table[name]) for name in ("point", "scenario", "signal", "unit")}


def scenario_fans(
    outcome: FlightOutcome, spec: ScenarioSpec, count: int, recorded: Fans | None = None
) -> list[PointFan]:
    """Return all finalists' fans in a scenario over `count` flights."""
    worst = worst_flights(outcome, spec.name).tolist()
    fans_of = [recorded.of(outcome.gains(row), spec.name) if recorded else None for row in range(len(worst))]
    inputs = drawn(outcome, spec, range(count)) if None in fans_of else None

    def fan_at(row: int) -> PointFan:
        index = worst[row]
        fan = fans_of[row] or fan_of(flight_of(outcome, row, inputs), index if index < count else 0)
        if fan.worst_flight == index:
            return fan
        alone = flight_of(outcome, row, drawn(outcome, spec, [index]))
        return fan._replace(worst=alone.actual[0], worst_flight=index)

    return parallel_map(fan_at, range(len(worst)))


def worst_flights(outcome: Outcome, scenario: str) -> np.ndarray:
    """Return each finalist's worst held-out flight of a scenario by index (rows,)."""
    judge = judging_objective(outcome.study, scenario)
    samples = outcome.finalists.evaluation.samples(judge, scenario)
    return np.array([first_largest(row) for row in samples])


def judging_objective(study: SearchedStudy, scenario: str) -> int:
    """Return the index of the objective that ranks a scenario's flights: the first that counts there."""
    return next((i for i, entry in enumerate(study.objectives) if entry.scenario in (None, scenario)), 0)


def drawn(outcome: FlightOutcome, spec: ScenarioSpec, indices: Any) -> Any:
    """Return held-out flights of a scenario by their indices."""
    return outcome.study.system.sample(spec, outcome.study.seed, HELD_OUT, indices)


def flight_of(outcome: FlightOutcome, row: int, inputs: Any) -> Responses:
    """Return a finalist's responses in sampled flights."""
    return responses_of(outcome.study.system, outcome.problem.flyer, outcome.gains(row), inputs)


def point_table(fan: PointFan, point: str, scenario: str) -> Columns:
    """Return the fan of one point as a long table."""
    instants, signals = len(fan.time), len(fan.signals)
    columns: Columns = {"point": point, "scenario": scenario}
    columns |= {"signal": each(fan.signals, instants), "unit": each(fan.units, instants)}
    columns |= {"time": np.tile(fan.time, signals)}
    columns |= {name: getattr(fan, name).T.ravel().astype(np.float32) for name in SERIES}
    return {**columns, "worst_flight": np.int32(fan.worst_flight)}


def each(texts: tuple[str, ...], count: int) -> np.ndarray:
    """Return each text so many times, as references to the one."""
    return np.repeat(np.array(texts, dtype=object), count)
