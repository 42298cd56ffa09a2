"""Stages of a tuning run, each with its most flights."""

from tuner.experiments.tuning.finalists import most_finalists
from tuner.experiments.tuning.survivors import MAX_SURVIVORS
from tuner.search.watcher import CHECKING, REFINING, SEARCHING
from tuner.study.searched import SearchedStudy

CONFIRMED = 2
"""Points that fly once more, on scenarios that decided nothing: the default and the recommended one."""


def stage_flights(study: SearchedStudy) -> dict[str, int]:
    """Return the most flights of each stage of a run, in order."""
    search, candidates = study.search, study.search.candidates
    first = sum(search.flights_first(entry.search) for entry in study.scenarios)
    rest = sum(entry.search for entry in study.scenarios) - first
    judged = min(candidates, most_finalists(study)) + 1 + CONFIRMED
    stages = {SEARCHING: candidates * first}
    if rest:
        stages[REFINING] = min(candidates, 1 + MAX_SURVIVORS) * rest
    return {**stages, CHECKING: judged * sum(entry.held_out for entry in study.scenarios)}
