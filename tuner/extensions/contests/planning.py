"""A contest before it runs: its content in numbers, and what it will take."""

from plant.backends.lane_layout import LANES
from tuner.experiments.planning.counts import flights_of, search_flights
from tuner.experiments.planning.pilot import Pilot
from tuner.experiments.planning.plan import plan_document, timed_pilot
from tuner.experiments.planning.study_preview import PreviewPart
from tuner.extensions.contests.documents import ContestPlanDocument, PlannedComparison, PlannedTotal
from tuner.extensions.contests.study import Contest
from tuner.search.watcher import Watcher
from tuner.study.comparison import Contender


class ContestPreview(PreviewPart):
    """A contest before anything flies; published, claims: how many it checks."""

    contenders: list[str]
    quantities: list[str]
    published: int
    claims: int
    search_flights: int
    comparison_flights_at_most: int
    halving: list[str] = []


def contest_preview(contest: Contest) -> ContestPreview:
    """Return a contest's preview."""
    return ContestPreview(
        kind="contest",
        title=contest.title,
        contenders=[_described(contender) for contender in contest.contenders],
        quantities=[quantity.label for quantity in contest.quantities],
        published=len(contest.published),
        claims=len(contest.claims),
        search_flights=contest_search_flights(contest),
        comparison_flights_at_most=comparison_flights(contest),
        **({"halving": contest.halving_texts} if contest.halving else {}),
    )


def _described(contender: Contender) -> str:
    searched = len(contender.study.space.variables)
    return f"{contender.name} ({f'{searched} searched' if searched else 'as given'})"


def plan_contest(contest: Contest, share: float, watcher: Watcher, threads: int | None) -> ContestPlanDocument:
    """Fly a pilot of every contender and plan the whole."""
    flown = [timed_pilot(entry.study, f"Pilot of {entry.name}", watcher, threads) for entry in contest.contenders]
    return contest_plan(contest, [pilot for pilot, _ in flown], [seconds for _, seconds in flown], share)


def contest_plan(
    contest: Contest, pilots: list[Pilot], compilation: list[float | None], share: float
) -> ContestPlanDocument:
    """Return the whole plan; pilots, compilation [s, None: done before]: one per contender; share: see `plan`."""
    parts = list(zip(contest.contenders, pilots, compilation, strict=True))
    runs = {
        contender.name: plan_document(contender.study, pilot, seconds, share)
        for contender, pilot, seconds in parts
        if contender.tuned
    }
    compared, left = comparison_flights(contest), contest.halving.finalists if contest.halving else len(runs)
    held_out = sum(sorted([run.flights.held_out_at_most for run in runs.values()], reverse=True)[:left])
    comparing = sum(comparison_seconds(contender, pilot) for contender, pilot, _ in parts)
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
            points_at_most=compared // contest.flights_each,
            flights_at_most=compared,
            seconds_at_most=comparing,
        ),
        total=PlannedTotal(
            flights_at_most=compared + contest_search_flights(contest) + held_out,
            seconds_at_most=comparing + sum(run.seconds.total_at_most for run in runs.values()),
            compilation_seconds=sum(compiled) if compiled else None,
            memory_bytes=max((run.memory_bytes for run in runs.values()), default=None),
            disk_bytes_at_most=sum(run.disk_bytes_at_most for run in runs.values()),
        ),
    )


def comparison_seconds(contender: Contender, pilot: Pilot) -> float:
    """Return the expected time [s] of a contender's comparison flights; threads fly blocks of lanes in parallel."""
    spent = 0.0
    for entry, flown in zip(contender.study.scenarios, pilot.scenarios, strict=True):
        blocks = points_at_most(contender) * -(-entry.held_out // LANES)
        spent += entry.held_out * flown.draw_seconds + blocks * flown.block_seconds / pilot.threads
    return spent


def contest_search_flights(contest: Contest) -> int:
    """Return the maximum number of search flights of a contest."""
    tuned = [contender.study for contender in contest.contenders if contender.tuned]
    if contest.halving is None:
        return sum(map(search_flights, tuned))
    searches = [(study.search.generations, search_flights(study) // study.search.generations) for study in tuned]
    return contest.halving.flights_at_most(searches)


def points_at_most(contender: Contender) -> int:
    """Return the maximum number of a contender's compared points: its own, and a front as long as it may get."""
    return 1 + (flights_of(contender.study).finalists_at_most if contender.tuned else 0)


def comparison_flights(contest: Contest) -> int:
    """Return the maximum number of a contest's comparison flights."""
    points = sorted(map(points_at_most, contest.contenders), reverse=True)
    return contest.flights_each * sum(points[: contest.halving.finalists] if contest.halving else points)
