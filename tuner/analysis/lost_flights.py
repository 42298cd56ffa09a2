"""Lost flights with their causes, and the effect of unseen losses."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from objectives.evaluator import Evaluator
from objectives.flown_system import FlightBatch, FlownSystem
from objectives.problem import Evaluation, Problem
from objectives.risk import clopper_pearson
from objectives.risk.shares import risk_of_share
from plant.backends.flyer import result_parts
from plant.status import Status
from tuner.documents.parts import LostFlight, ShareCount
from tuner.documents.summary import RaisedValue, UnseenLosses

STATUSES = tuple(Status)
MAX_NAMED_FLIGHTS = 20


def fly_alone(problem: Problem, gains: np.ndarray, spec: Any, stream: str, indices: Sequence[int]) -> np.ndarray:
    """Return the results (flights, rows) of single flights of a gains row (g,).

    They are not stored.
    """
    inputs = problem.system.sample(spec, problem.root, stream, indices)
    return problem.flyer.fly(gains[None], problem.system.nominal, inputs)[0]


def lost_among(
    results: np.ndarray, system: FlownSystem, spec: Any, stream: str, indices: Sequence[int], point: str = ""
) -> list[LostFlight]:
    """Return the lost flights among results (flights, rows).

    indices: the flights' numbers in the stream.
    """
    _, status, end = result_parts(results)
    return [
        lost_flight(system, spec, stream, indices[i], STATUSES[int(status[i])], float(end[i]), point)
        for i in np.flatnonzero(status).tolist()
    ]


def lost_flight(
    system: FlownSystem, spec: Any, stream: str, index: int, status: Status, time: float, point: str = ""
) -> LostFlight:
    """Return a flight that ended with a status at a time [s]."""
    cause, limit = system.failure_causes[status]
    return LostFlight(
        name=f"{stream}-{index}",
        scenario=spec.name,
        stream=stream,
        index=index,
        point=point,
        time=time,
        cause=cause,
        limit=limit,
    )


def named_losses(
    problem: Evaluator, gains: np.ndarray, batches: tuple[FlightBatch, ...], failed: np.ndarray, point: str
) -> list[LostFlight]:
    """Return the first `MAX_NAMED_FLIGHTS` lost flights of a gains row (g,).

    They are flown once more for their causes; none where another program makes the flights.
    failed (flights,): which of the flights of all batches were lost.
    """
    if not isinstance(problem, Problem):
        return []
    flights, start = list[LostFlight](), 0
    for batch in batches:
        lost = np.flatnonzero(failed[start : start + batch.count])[: MAX_NAMED_FLIGHTS - len(flights)].tolist()
        start += batch.count
        if lost:
            results = fly_alone(problem, gains, batch.spec, batch.stream, lost)
            flights += lost_among(results, problem.system, batch.spec, batch.stream, lost, point)
    return flights


def loss_costs(problem: Evaluator, batches: tuple[FlightBatch, ...]) -> np.ndarray:
    """Return the costs (quantities,) of a flight that is lost at once: no flight has more."""
    return np.max([problem.unflown(batch, 1)[0][0, :, 0] for batch in batches], axis=0)


def unseen_losses(
    problem: Evaluator, batches: tuple[FlightBatch, ...], evaluation: Evaluation, row: int
) -> UnseenLosses | None:
    """Return the effect of losses unseen in a row's flights: None if some were lost or nothing would move."""
    flights = int(evaluation.flights_each[row])
    if evaluation.lost[row]:
        return None
    costs = loss_costs(problem, batches)
    moved = []
    for i, objective in enumerate(problem.objectives):
        if objective.risk.name not in ("mean", "cvar") or objective.is_binary:
            continue
        count = evaluation.samples(i, objective.scenario).shape[-1]
        value = float(evaluation.values[row, i])
        share = float(risk_of_share(clopper_pearson(0, count).high, objective.risk))
        raised = value + share * max(float(costs[i]) - value, 0.0)
        moved.append(RaisedValue(label=objective.label, unit=objective.metric.unit, value=value, raised=raised))
    return UnseenLosses(count=ShareCount.of(np.zeros(flights)), objectives=moved) if moved else None
