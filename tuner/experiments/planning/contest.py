"""Flights, time, memory and disk of a contest: the runs of those that are tuned, then all points through the same flights."""

from plant.backends.lanes import LANES
from tuner.documents.plan import ContestPlanDocument, PlannedComparison, PlannedTotal
from tuner.experiments.planning.cost import flights_of
from tuner.experiments.planning.document import plan_document
from tuner.experiments.planning.pilot import Pilot
from tuner.study.contest import Contender, Contest


def points_at_most(contender: Contender) -> int:
    """Return how many points of a contender are compared at most: its own, and a front as long as it may get."""
    return 1 + (flights_of(contender.study).finalists if contender.tuned else 0)


def comparison_flights(contest: Contest) -> int:
    """Return how many flights the comparison takes at most."""
    return contest.flights_each * sum(map(points_at_most, contest.contenders))


def comparison_seconds(contender: Contender, pilot: Pilot) -> float:
    """Return how long the points of a contender fly in the comparison [s]; threads fly blocks of lanes side by side."""
    spent = 0.0
    for entry, flown in zip(contender.study.scenarios, pilot.scenarios, strict=True):
        blocks = points_at_most(contender) * -(-entry.held_out // LANES)
        spent += entry.held_out * flown.draw_seconds + blocks * flown.block_seconds / pilot.threads
    return spent


def contest_plan(
    contest: Contest, pilots: list[Pilot], compilation: list[float | None], share: float
) -> ContestPlanDocument:
    """Return the whole plan; pilots, compilation [s, None: done before]: of each contender; share: the difference to be told."""
    found = list(zip(contest.contenders, pilots, compilation, strict=True))
    runs = {
        contender.name: plan_document(contender.study, pilot, seconds, share)
        for contender, pilot, seconds in found
        if contender.tuned
    }
    compared = comparison_flights(contest)
    comparing = sum(comparison_seconds(contender, pilot) for contender, pilot, _ in found)
    compiled = [seconds for seconds in compilation if seconds is not None]
    return ContestPlanDocument(
        title=contest.title,
        study=contest.path.name,
        digest=contest.digest(),
        seed=contest.seed,
        runs=runs,
        comparison=PlannedComparison(
            stream=contest.stream,
            flights_each=contest.flights_each,
            points_at_most=sum(map(points_at_most, contest.contenders)),
            flights_at_most=compared,
            seconds_at_most=comparing,
        ),
        total=PlannedTotal(
            flights_at_most=compared + sum(run.flights.total_at_most for run in runs.values()),
            seconds_at_most=comparing + sum(run.seconds.total_at_most for run in runs.values()),
            compilation_seconds=sum(compiled) if compiled else None,
            memory_bytes=max((run.memory_bytes for run in runs.values()), default=None),
            disk_bytes_at_most=sum(run.disk_bytes_at_most for run in runs.values()),
        ),
    )
