"""Flights of settings: of the held-out stream, from the first on, as `tuner fly --study` makes them.

Flights are kept by their gains, so that a setting that is shown again, and the default in every answer, fly once.
"""

from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from objectives.evaluator import OF_CANDIDATES
from objectives.problem import Evaluation, FlightBatch, Problem
from objectives.requirements import first_values, further_values, worst_value
from plant.backends.flyer import FlightInputs
from plant.quadrotor.scenarios import HELD_OUT
from tuner.analysis.lost_flights import loss_costs
from tuner.analysis.responses import Responses, responses_of
from tuner.api.flying import FAN_FLIGHTS
from tuner.documents.tables import Fan
from tuner.experiments.tuning.problem import problem_of
from tuner.report.sheets import fans_of
from tuner.study.tuning_study import TuningStudy

Array = np.ndarray
K = TypeVar("K")
V = TypeVar("V")
STAGES = (16, 64, 256)
"""Numbers of flights of each scenario, one stage of an answer after the other."""
MAX_SETTINGS = 48
"""Settings whose flights are kept; those of the oldest are dropped."""


class Recent(OrderedDict[K, V]):
    """Values of the keys that were needed last."""

    def get_or_make(self, key: K, make: Callable[[], V]) -> V:
        """Return the value of a key, made where there is none."""
        if key not in self:
            self[key] = make()
        self.move_to_end(key)
        while len(self) > MAX_SETTINGS:
            self.popitem(last=False)
        return self[key]


class KeptFlights:
    """Results of flights by gains row, from flight 0 on; a `FlightMemory` in memory."""

    def __init__(self) -> None:
        self._rows = Recent[bytes, dict[str, Array]]()

    def recall(self, key: str, gains: Array, first: int, last: int) -> Array | None:
        """Return the results (last - first, rows), None if some are missing."""
        row = gains.tobytes()
        results = self._rows.get(row, {}).get(key)
        if results is not None:
            self._rows.move_to_end(row)
        return None if results is None or len(results) < last else results[first:last]

    def keep(self, key: str, batch: FlightBatch, gains: Array, first: int, results: Array) -> None:  # noqa: ARG002
        """Add the results (n, flights, rows) of gains rows (n, g) from flight `first` on."""
        for row, made in zip(gains, results, strict=True):
            by_key = self._rows.get_or_make(row.tobytes(), dict)
            before = by_key.get(key)
            count = 0 if before is None else len(before)
            if first <= count < first + len(made):
                by_key[key] = made.copy() if before is None else np.concatenate([before[:first], made])

    def commit(self, name: str) -> None:
        """Write nothing: these flights end with the page."""


class Flights:
    """Flights of the settings of a study; threads: by default one for each core."""

    def __init__(self, study: TuningStudy, threads: int | None = None) -> None:
        self.study = study
        self.problem: Problem = problem_of(study, threads, KeptFlights())
        self._inputs = Recent[tuple[int, int], FlightInputs]()
        self._fans = Recent[tuple[bytes, int, int], list[Fan]]()
        self._costs = Recent[int, Array]()

    def batches(self, flights: int) -> tuple[FlightBatch, ...]:
        """Return the first flights of each scenario."""
        return tuple(FlightBatch(entry.spec, HELD_OUT, flights) for entry in self.study.scenarios)

    def evaluate(self, rows: Array, flights: int) -> Evaluation:
        """Return the evaluation of gains rows (n, g).

        flights: number of each scenario, from the first on; with those of the first stage limits on margins are looked at as a
        search does, see `search_values`.
        """
        before = 0
        for last in (*[stage for stage in STAGES if stage < flights], flights):
            self._fly_on(rows, before, last)
            before = last
        return self.problem.evaluate_gains(rows, self.batches(flights), fly_all=True, complete=flights > STAGES[0])

    def _fly_on(self, rows: Array, first: int, last: int) -> None:
        """Fly from one stage to the next."""
        for entry in self.study.scenarios:
            batch = FlightBatch(entry.spec, HELD_OUT, last, first)
            for begin, end in self.problem.chunks(batch):
                self.problem.results(rows, batch, begin, end)

    def fans(self, row: Array, scenario: int, flights: int) -> list[Fan]:
        """Return the bands of at most 64 responses of gains (g,)."""
        count = min(flights, FAN_FLIGHTS)
        # Bands of quickstart take 0.16 MB, its responses 4 MB.
        return self._fans.get_or_make(
            (row.tobytes(), scenario, count),
            lambda: fans_of(self.responses(row, scenario, count), self.study.scenarios[scenario].spec.name),
        )

    def responses(self, row: Array, scenario: int, count: int) -> Responses:
        """Return the recorded responses of a gains row (g,)."""
        return responses_of(self.problem.system, self.problem.flyer, row, self._drawn(scenario, count))

    def _drawn(self, scenario: int, count: int) -> FlightInputs:
        spec, draw = self.study.scenarios[scenario].spec, self.problem.system.sample
        return self._inputs.get_or_make((scenario, count), lambda: draw(spec, self.study.seed, HELD_OUT, range(count)))

    def costs(self, flights: int) -> Array:
        """Return the costs (quantities,) of a flight lost at once."""
        return self._costs.get_or_make(flights, lambda: loss_costs(self.problem, self.batches(flights)))


def search_values(problem: Problem, rows: Array) -> Array:
    """Return the values (n, requirements) in the steady states of a search.

    rows: gains rows (n, g). Values near a limit are not read again exactly: that takes 0.7 s where position loops wait.
    """
    both = np.stack([first_values(problem.screens, rows), further_values(problem.screens, rows)])
    return worst_value(problem.requirements, both)


def rows_of(evaluation: Evaluation, rows: Sequence[int]) -> Evaluation:
    """Return some rows of an evaluation as an evaluation."""
    picked = {name: getattr(evaluation, name)[list(rows)] for name in OF_CANDIDATES}
    failed = None if evaluation.failed is None else evaluation.failed[list(rows)]
    return replace(evaluation, **picked, failed=failed)
