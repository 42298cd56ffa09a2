"""The problem of a study whose trials another program runs: scores come from the recorded results.

Missing results stop the evaluation: the search is replayed from its seed every time, as far as the record goes.
"""

from collections.abc import Callable
from itertools import chain

import numpy as np

from objectives.metrics.metric import Metric
from objectives.problem import Evaluator, FlightBatch
from plant.quadrotor.scenarios import SEARCH
from tuner.extensions.trials.record import ROUNDING, Answer, Trial, TrialRecord
from tuner.extensions.trials.study import FAILED, TrialStudy
from tuner.search.loop import point_name

Array = np.ndarray
BatchRunner = Callable[[list[Trial]], None]
"""Runs trials and records their results."""


class MissingResultError(Exception):
    """A replay reached trials without results."""

    def __init__(self, trials: list[Trial]) -> None:
        self.trials = trials
        super().__init__(f"{len(trials)} trials have no results")


class TrialProblem(Evaluator):
    """Evaluator by recorded trials. answer: runs missing ones; without it `MissingResultError` is raised."""

    # The time that a program takes over its trials is not recorded.
    now = staticmethod(lambda: 0.0)

    def __init__(self, study: TrialStudy, record: TrialRecord, answer: BatchRunner | None = None) -> None:
        super().__init__(study.space, study.objectives, study.constraints)
        self._study, self._record, self._answer = study, record, answer
        self._names: dict[bytes, str] = {}
        self._tried = 0

    def scored(
        self,
        gains: Array,
        flown: Array,
        batch: FlightBatch,
        first: int,
        last: int,
        on_flights_done: Callable[[int], None] | None = None,
    ) -> tuple[Array, Array]:
        """Return scores (n, quantities, last - first) and failures (n, last - first) of rows of variables (n, g)."""
        trials = [
            [self.trial(row, batch.stream, i) for i in range(first, last)] for row in self._named(gains, batch, first)
        ]
        self.require_results(list({trial.id: trial for trial in chain(*trials)}.values()))
        answers = [[self._record.answers[trial.id] for trial in row] for row in trials]
        if on_flights_done is not None:
            on_flights_done(len(gains) * (last - first))
        scores = [
            [[score(quantity.metric.metric, answer) for answer in row] for quantity in self.quantities]
            for row in answers
        ]
        shape = len(gains), len(self.quantities), last - first
        failed = np.array([[answer.failed for answer in row] for row in answers], dtype=bool)
        return np.array(scores).reshape(shape), failed.reshape(len(gains), last - first)

    def unflown(self, batch: FlightBatch, flights: int) -> tuple[Array, Array]:
        """Return scores (1, quantities, flights) and failures (1, flights) of a candidate that is not tried."""
        lost = Answer(id="", failed=True)
        costs = np.array([score(quantity.metric.metric, lost) for quantity in self.quantities])
        return np.repeat(costs[None, :, None], flights, axis=2), np.ones((1, flights), dtype=bool)

    def require_results(self, trials: list[Trial]) -> None:
        """Run the trials without results; MissingResultError where none can run."""
        self._record.ask(trials)
        if self._answer is not None:
            self._answer([trial for trial in trials if trial.id not in self._record.answers])
        pending = [trial for trial in trials if trial.id not in self._record.answers]
        if pending:
            raise MissingResultError(pending)

    def trial(self, row: Array, stream: str, scenario: int) -> Trial:
        """Return the trial of variables (g,) in a scenario of a stream."""
        candidate, name = self._name(row, stream), f"{stream}-{scenario:03d}"
        return Trial(
            id=f"{candidate}-{name}",
            candidate=candidate,
            scenario=name,
            seed=self._study.trial_seed(stream, scenario),
            variables=dict(zip(self._study.names, self._unrounded(row).tolist(), strict=True)),
        )

    def _unrounded(self, row: Array) -> Array:
        """Return the default in place of its rounded row."""
        default = self._study.default_row
        return default if np.allclose(row, default, rtol=ROUNDING, atol=0.0) else row

    def _name(self, row: Array, stream: str) -> str:
        """Return the name of a candidate: its number, or "default" outside of the search."""
        key = row.tobytes()
        return "default" if stream != SEARCH and key == self._study.default_row.tobytes() else self._names[key]

    def _named(self, gains: Array, batch: FlightBatch, first: int) -> Array:
        """Return the rows, naming new candidates of the search by their numbers."""
        if batch.stream == SEARCH and first == 0:
            for row in gains:
                self._names.setdefault(row.tobytes(), point_name(self._tried))
                self._tried += 1
        return gains


def score(metric: Metric, answer: Answer) -> float:
    """Return the score of a trial for a metric: its value, at most the bound, and beyond that where it failed."""
    worst = metric.bound(answer.metrics)
    if answer.metrics is None:
        return FAILED * worst if metric.graded else worst
    return min(metric.value(answer.metrics), worst)
