"""Scores of two files of gains on the same flights: means, their differences, lost flights."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import expm1

import numpy as np

from objectives.metrics import MetricAddress
from objectives.problem import Objective
from objectives.risk import Risk
from plant.seeds import generator
from tuner.analysis.judging.opinion import compare_means
from tuner.analysis.judging.rows import REPLICATES
from tuner.documents.assessment import NOT_DISTINGUISHABLE, AssessedMetric
from tuner.documents.parts import SampledValue, ShareCount

FAILURE = "failure"


@dataclass(frozen=True)
class PairedScores:
    """Scores of flights.

    Attributes:
        metrics: The metrics, failure first.
        scores: Values (files, metrics, flights): of the file that is judged, then of the one before, if there is one.
        seed: Root seed of the resamples.
    """

    metrics: Sequence[MetricAddress]
    scores: np.ndarray
    seed: int

    @property
    def lost(self) -> list[ShareCount]:
        """Lost flights of each file."""
        return [ShareCount.of(failed) for failed in self.scores[:, 0]]

    @property
    def loss_difference(self) -> SampledValue | None:
        """Probability of loss, after less before, with its interval; None for one file."""
        return self._difference(0, self.scores[:, 0]) if len(self.scores) > 1 else None

    @property
    def rows(self) -> list[AssessedMetric]:
        """Means over the flights that no file loses, or all."""
        is_completed = np.all(self.scores[:, 0] == 0.0, axis=0)
        scores = self.scores[:, :, is_completed] if is_completed.any() else self.scores
        return [self._row(index, scores) for index in range(1, len(self.metrics))]

    def _row(self, index: int, scores: np.ndarray) -> AssessedMetric:
        metric, values = self.metrics[index], scores[:, index]
        means, difference = values.mean(axis=-1).tolist(), None
        before = means[1] if len(means) > 1 else None
        if before is not None and np.all(values > 0.0):
            # Ratios of paired flights: a class has vehicles with ten times the noise of others.
            difference = SampledValue(*map(expm1, self._difference(index, np.log(values))))
        return AssessedMetric(
            metric=metric.text,
            definition=metric.metric.definition,
            unit=metric.unit,
            before=before,
            after=means[0],
            difference=difference,
            verdict=NOT_DISTINGUISHABLE if difference is None else compare_means(metric.text, difference),
        )

    def _difference(self, index: int, values: np.ndarray) -> SampledValue:
        """Return the difference of the means of values (2, flights)."""
        flights = values.shape[-1]
        resample = generator(self.seed, "judge/bootstrap", 0).integers(flights, size=(REPLICATES, flights))
        objective = Objective(self.metrics[index], Risk("mean"))
        return SampledValue(*map(float, objective.difference(values[0], values[1], resample)))
