"""Growth of the flights of a search: more of them where fresh ones disagree with those that it goes by.

A search fits itself to its flights, and eight lenient ones mislead it for good: more candidates on the same flights do not help.
So some points of the front make as many fresh flights every 32 candidates. If an objective is worse there by a fifth, or a
limit is broken, all candidates make these flights too, and those to come; the search goes on from values that rest on both.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import ceil

import numpy as np

from objectives.evaluator import Evaluation, Evaluator
from objectives.problem import FlightBatch
from plant.quadrotor.scenarios import SEARCH
from tuner.experiments.tuning.problem import batches
from tuner.experiments.tuning.survivors import joined
from tuner.search.front import select_subset
from tuner.search.loop import Generation, RevisableSearch, Search, archive
from tuner.study.searched import SearchedStudy

# Candidates from one check to the next, and points of the front that make fresh flights. With 64 candidates one of five seeds of
# the figure eight ended at 0.93 of the best known and fifteen hundred flights brought 0.80, with 32 at 0.99 and 0.91.
CHECK_EVERY, MAX_CHECKED_POINTS = 32, 4
# Median ratio of an objective on fresh flights to that on the search's from which on more are made. Where these are enough it is
# 1.0 to 1.15, for the front was picked on them; of a misled search it was 1.5 (a gust, 8 flights, recovery time).
MAX_RATIO = 1.2


class FlightGrowth:
    """The number of flights that candidates of a search make.

    study: the study with the number so far; text: sentence on the latest growth.

    Args:
        problem: Evaluates the candidates.
        study: The study at its beginning.
        algorithm: Its search: flights grow where it takes other values for points that it has asked for.
        on_flights_done: Called with n as n more flights have ended.
    """

    def __init__(
        self,
        problem: Evaluator,
        study: SearchedStudy,
        algorithm: Search,
        on_flights_done: Callable[[int], None] | None = None,
    ) -> None:
        self.study, self.text = study, ""
        self.problem, self.on_flights_done = problem, on_flights_done
        self._may_grow = isinstance(algorithm, RevisableSearch) and study.search.flight_growth

    def review(self, generations: Sequence[Generation]) -> list[Evaluation] | None:
        """Return evaluations of all generations on more flights; None where those so far are enough or all are made."""
        further = self._further()
        every = generations_between_checks(self.study)
        if not further or len(generations) % every or len(generations) >= self.study.search.generations:
            return None
        tried = archive(list(generations))
        front = tried.front()
        if not len(front) or not self._misleads(tried.points, tried.values, front, further):
            return None
        before = self.study
        self.study = with_first(before, max(batch.count for batch in further))
        self.text = (
            f"Fresh flights of the front are worse than the search's by more than {MAX_RATIO - 1.0:.0%} in an objective, or "
            "beyond a limit: "
            f"every candidate makes {self.study.search.first or 'all'} flights of each scenario from now on, "
            f"{before.search.first} before."
        )
        return [self._extended(generation, further) for generation in generations]

    def _further(self) -> tuple[FlightBatch, ...]:
        """Return the flights that candidates would make beyond those so far; none where there are no more."""
        first = self.study.search.first
        if first is None or not self._may_grow:
            return ()
        later = [
            replace(batch, start=first, count=min(2 * first, batch.count)) for batch in batches(self.study, SEARCH)
        ]
        return tuple(batch for batch in later if batch.count > batch.start)

    def _misleads(
        self, points: np.ndarray, values: np.ndarray, front: np.ndarray, further: tuple[FlightBatch, ...]
    ) -> bool:
        """Return True where the front is worse on fresh flights."""
        chosen = front[select_subset(values[front], values[0], MAX_CHECKED_POINTS, ends=False)]
        fresh = self.problem.evaluate(points[chosen], further, self.on_flights_done, fly_all=True)
        # A scenario whose flights are all made has no fresh ones, and its objectives no values.
        ratios = np.nan_to_num(value_ratios(values[chosen], fresh.values), nan=1.0)
        limited = [i for i, entry in enumerate(self.problem.constraints) if entry.has_tolerance]
        # The front keeps its limits by the flights so far; fresh ones that break one in half of it were not in its choice.
        broken = np.median(np.nan_to_num(fresh.excess[:, limited], nan=-1.0), axis=0) > 0.0
        return bool(np.any(np.median(ratios, axis=0) > MAX_RATIO) or np.any(broken))

    def _extended(self, generation: Generation, further: tuple[FlightBatch, ...]) -> Evaluation:
        """Return the evaluation of a generation on its flights and further ones."""
        one = generation.evaluation
        other = self.problem.evaluate(generation.points, further, self.on_flights_done, fly_all=one.flown)
        both = joined(self.problem, one, other)
        return replace(both, flight_seconds=one.flight_seconds + other.flight_seconds)


def generations_between_checks(study: SearchedStudy) -> int:
    """Return the number of generations from check to check."""
    return ceil(CHECK_EVERY / study.search.population)


def value_ratios(before: np.ndarray, fresh: np.ndarray) -> np.ndarray:
    """Return fresh values (n, m) in those before, NaN where these are 0."""
    return fresh / np.where(before > 0.0, before, np.nan)


def grown_study(study: SearchedStudy, generations: Sequence[Generation]) -> SearchedStudy:
    """Return a study with the number of flights that its generations made."""
    origin = generations[-1].evaluation.origin
    if study.search.first is None:
        return study
    return with_first(study, max(int(np.sum(origin == entry.spec.name)) for entry in study.scenarios))


def with_first(study: SearchedStudy, first: int) -> SearchedStudy:
    """Return a study whose candidates make so many flights first."""
    staged = first < max(entry.search for entry in study.scenarios)
    return replace(study, search=replace(study.search, first=first if staged else None))
