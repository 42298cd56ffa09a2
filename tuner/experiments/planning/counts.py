"""Largest numbers of flights of runs, counted from their studies.

Unknown counts are taken at their largest: candidates that break a hard requirement, or that a race would stop early,
are counted as flown, and the front as long as it may get. Further flights of finalists that straddle a limit come on top, see
`tuner.analysis.limit_flights.most_further_flights`.
"""

from typing import Any

from tuner.documents.plan import PlannedFlights
from tuner.experiments.tuning.finalists import most_finalists
from tuner.experiments.tuning.survivors import MAX_EXTRA_SURVIVORS, MAX_SURVIVORS
from tuner.study.study import SearchedStudy

CONFIRMED = 2
"""The default and the recommended point fly once more, on scenarios that decided nothing."""


def search_flights(study: SearchedStudy) -> int:
    """Return the maximum number of search flights."""
    return sum(scenario_flights(study, entry) for entry in study.scenarios)


def scenario_flights(study: SearchedStudy, entry: Any) -> int:
    """Return the maximum number of search flights of a scenario."""
    first = study.search.flights_first(entry.search)
    return study.search.candidates * first + survivors_at_most(study) * (entry.search - first)


def survivors_at_most(study: SearchedStudy) -> int:
    """Return the maximum number of candidates with all search flights: the first one and those that survive."""
    return min(study.search.candidates, 1 + MAX_SURVIVORS + MAX_EXTRA_SURVIVORS)


def flights_of(study: SearchedStudy) -> PlannedFlights:
    """Return the maximum number of flights of a run."""
    search, each = search_flights(study), sum(entry.held_out for entry in study.scenarios)
    finalists = min(study.search.candidates, most_finalists(study))
    held_out = judged_at_most(finalists) * each
    return PlannedFlights(
        search_at_most=search,
        held_out_each=each,
        finalists_at_most=finalists,
        held_out_at_most=held_out,
        total_at_most=search + held_out,
    )


def judged_at_most(finalists: int) -> int:
    """Return the number of candidates in held-out check and confirmation: finalists, the default, and two again."""
    return finalists + 1 + CONFIRMED
