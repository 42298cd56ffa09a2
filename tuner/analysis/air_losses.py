"""Flights that the air lost: the default and every finalist lose them, so they say nothing about gains.

A gust that no gains of a vehicle can meet would end every run that allows no loss, whatever it recommends. Such a flight is named
and does not count: its scores are the mean of the point's other flights in the scenario. If more than `MAX_SHARE` of the
flights are lost by all, the study asks for more than any gains reach, and that counts.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from objectives.evaluator import Evaluation, Evaluator
from objectives.flown_system import FlightBatch
from objectives.problem import Problem
from plant.backends.flyer import result_parts
from tuner.analysis.final_flights import FinalFlights
from tuner.analysis.lost_flights import fly_alone

MAX_SHARE = 0.05
"""Share of the flights that the air may lose; one flight always."""
MIN_POINTS = 3
"""Points that must all lose a flight, the default among them: two may share a weakness."""


def air_losses(
    problem: Evaluator, gains: np.ndarray, batches: tuple[FlightBatch, ...], suspects: np.ndarray
) -> np.ndarray:
    """Return the mask of the suspects (flights,) that every gains row (rows, g) loses; none where there are too many."""
    most = max(1.0, MAX_SHARE * len(suspects))
    if not isinstance(problem, Problem) or len(gains) < MIN_POINTS or not 0 < suspects.sum() <= most:
        return np.zeros(len(suspects), dtype=bool)
    return np.all(losses(problem, gains, batches, suspects), axis=0)


def losses(problem: Problem, gains: np.ndarray, batches: tuple[FlightBatch, ...], suspects: np.ndarray) -> np.ndarray:
    """Return the mask (rows, flights) of the suspects (flights,) that each gains row (rows, g) loses."""
    out, start = np.zeros((len(gains), len(suspects)), dtype=bool), 0
    for batch in batches:
        flights = np.flatnonzero(suspects[start : start + batch.count - batch.start])
        numbers = (batch.start + flights).tolist()
        if numbers:
            out[:, start + flights] = [is_lost(problem, row, batch, numbers) for row in gains]
        start += batch.count - batch.start
    return out


def is_lost(problem: Problem, gains: np.ndarray, batch: FlightBatch, numbers: Sequence[int]) -> np.ndarray:
    """Return the mask (flights,) of lost flights of a gains row (g,)."""
    _, status, _ = result_parts(fly_alone(problem, gains, batch.spec, batch.stream, numbers))
    return np.asarray(status != 0)


def air_of_finals(flown: FinalFlights, gains: np.ndarray, batches: tuple[FlightBatch, ...]) -> np.ndarray:
    """Return the mask (flights,) of the held-out flights that the air lost."""
    made = flown.early | flown.complete[:, None]
    return air_losses(flown.problem, gains, batches, np.all(flown.failed | ~made, axis=0))


def excused_finals(flown: FinalFlights, air: np.ndarray) -> FinalFlights:
    """Return held-out flights without the losses of the air."""
    if not air.any():
        return flown
    scores = excused(flown.problem, flown.scores, flown.origin, air)
    return replace(flown, scores=scores, failed=flown.failed & ~air)


def excused_evaluation(problem: Evaluator, evaluation: Evaluation, air: np.ndarray) -> Evaluation:
    """Return an evaluation without the losses of the air."""
    if not air.any() or evaluation.failed is None:
        return evaluation
    scores, failed = excused(problem, evaluation.scores, evaluation.origin, air), evaluation.failed & ~air
    risks, m = problem.risks(scores, evaluation.origin), len(problem.objectives)
    required = evaluation.excess[:, len(problem.constraints) :]
    return replace(
        evaluation,
        scores=scores,
        failed=failed,
        failures=failed.mean(axis=-1),
        values=risks[:, :m],
        excess=np.concatenate([problem.constraint_excess(risks), required], axis=1),
    )


def excused(problem: Evaluator, scores: np.ndarray, origin: np.ndarray, air: np.ndarray) -> np.ndarray:
    """Return scores (rows, quantities, flights) without the losses of the air.

    A lost flight has the mean of the others in its scenario.
    """
    out, is_binary = scores.copy(), np.array([entry.is_binary for entry in problem.quantities])
    for name in np.unique(origin[air]):
        lost, others = air & (origin == name), ~air & (origin == name)
        mean = scores[..., others].mean(axis=-1) if others.any() else np.zeros(scores.shape[:2])
        out[..., lost] = np.where(is_binary, np.rint(mean), mean)[..., None]
    return out
