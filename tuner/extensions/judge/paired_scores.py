"""Scores of two files of gains on the same flights: means, their differences, lost flights."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import expm1

import numpy as np

from objectives.metrics import MetricAddress
from objectives.problem import Objective
from objectives.risk import RELEVANT, Risk, minimum_samples
from objectives.risk.differences import NOT_DISTINGUISHABLE
from plant.seeds import generator
from tuner.analysis.judged_rows import REPLICATES
from tuner.documents.assessment import AssessedMetric, AssessedScenario
from tuner.documents.parts import SampledValue, ShareCount
from tuner.documents.verdicts import verdict_on_difference
from tuner.extensions.judge.scenarios import POSITION, JudgedScenario

MEAN = Risk("mean")
MAX_LOGARITHM = 700.0
"""Largest logarithm of a ratio whose exponential is finite: the interval of two flights can reach beyond it."""
TAIL = Risk("cvar", 0.9)
"""Risk of the position next to its mean, in which vehicles in the worst air count no more than others."""


@dataclass(frozen=True)
class PairedScores:
    """Scores of flights.

    Attributes:
        metrics: The metrics, failure first.
        scores: Values (files, metrics, flights): of the file that is judged, then of the one before, if there is one.
        seed: Root seed of the resamples.
        scenario: Scenario that was flown; None compares all metrics of a first flight.
        relevant: Share of the value before from which a difference matters.
    """

    metrics: Sequence[MetricAddress]
    scores: np.ndarray
    seed: int
    scenario: JudgedScenario | None = None
    relevant: float = RELEVANT

    @property
    def lost(self) -> list[ShareCount]:
        """Lost flights of each file."""
        return [ShareCount.of(failed) for failed in self.scores[:, 0]]

    @property
    def loss(self) -> str | None:
        """Word on the probability of loss next to that before; None for one file."""
        if len(self.scores) == 1:
            return None
        failed = self.scores[:, 0]
        return verdict_on_difference(float(failed[1].mean()), self._difference(0, failed), self.relevant)

    @property
    def rows(self) -> list[AssessedMetric]:
        """Risks over the flights that no file loses, or all; many flights have a tail of the position."""
        is_completed = np.all(self.scores[:, 0] == 0.0, axis=0)
        scores = self.scores[:, :, is_completed] if is_completed.any() else self.scores
        has_tail = scores.shape[-1] >= minimum_samples(TAIL)
        return [
            self._row(index, risk, scores[:, index])
            for index, metric in enumerate(self.metrics)
            if index and (self.scenario is None or metric.text in self.scenario.metrics)
            for risk in ((MEAN, TAIL) if has_tail and metric.text == POSITION else (MEAN,))
        ]

    @property
    def summary(self) -> AssessedScenario:
        """Flights of the scenario, and how many of them each file loses."""
        assert self.scenario is not None, "scores of an opinion have a scenario"
        after, *before = self.lost
        return AssessedScenario(
            name=self.scenario.spec.name,
            flights=after.flights,
            lost_after=after,
            lost_before=before[0] if before else None,
            loss=self.loss,
        )

    def _row(self, index: int, risk: Risk, values: np.ndarray) -> AssessedMetric:
        metric, difference = self.metrics[index], None
        after, *before = risk.apply(values).tolist()
        if before and np.all(values > 0.0):
            difference = self._change(index, risk, values)
        return AssessedMetric(
            metric=metric.text,
            risk=str(risk),
            scenario=None if self.scenario is None or self.scenario.share == 1 else self.scenario.spec.name,
            definition=metric.metric.definition,
            unit=metric.unit,
            before=before[0] if before else None,
            after=after,
            difference=difference,
            verdict=self._word(difference) if before else None,
        )

    def _word(self, change: SampledValue | None) -> str:
        """Return the word on a change, None if there is no ratio."""
        if change is None:
            return NOT_DISTINGUISHABLE
        # A change is a share of the value before already.
        return verdict_on_difference(1.0, change, self.relevant)

    def _change(self, index: int, risk: Risk, values: np.ndarray) -> SampledValue:
        """Return after over before, less 1: the geometric mean of paired flights, or the ratio of both tails."""
        if risk.is_mean:
            # Ratios of paired flights: a class has vehicles with ten times the noise of others.
            logarithms = self._difference(index, np.log(values))
            return SampledValue(*(expm1(min(part, MAX_LOGARITHM)) for part in logarithms))
        before = float(risk.apply(values[1]))
        return SampledValue(*(part / before for part in self._difference(index, values, risk)))

    def _difference(self, index: int, values: np.ndarray, risk: Risk = MEAN) -> SampledValue:
        """Return the difference of the risks of values (2, flights)."""
        flights = values.shape[-1]
        resample = generator(self.seed, "judge/bootstrap", 0).integers(flights, size=(REPLICATES, flights))
        objective = Objective(self.metrics[index], risk)
        return SampledValue(*map(float, objective.difference(values[0], values[1], resample)))
