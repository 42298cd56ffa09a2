"""Distance inside binding limits at which the generations of a search aim.

With an addition to the excess of all candidates over a limit a search proposes points further inside, and the held-out check has
points on both sides of the limit that it judges by. The last generations of a search of one objective aim at a single distance,
which more flights measure: so the finalists lie close together at the limit.
"""

from collections.abc import Sequence

import numpy as np

from objectives.evaluator import Evaluation, concatenate_evaluations
from tuner.experiments.tuning.active_limits import widths
from tuner.experiments.tuning.flight_growth import generations_between_checks
from tuner.experiments.tuning.limit_watch import LimitWatch, has_one
from tuner.search.front import feasible_front
from tuner.search.loop import Generation, hypervolumes

AIMS = (0.0, 0.25, 0.5)
"""Parts of an interval by which generations, one after the other, aim further inside, or further outside of a back-off."""
GENERATIONS_PER_LAST = 8
"""Generations of a search of one objective for each of its last ones: 3 of 26, which aim at the back-off alone. A hover's
objective fell by 9 %, from 6.9 % behind the best known then to 2.6 % before it."""


class LimitAim:
    """Addition to the excess of all candidates, by generation.

    Args:
        watch: Measures the back-off from limits by fresh flights.
    """

    def __init__(self, watch: LimitWatch) -> None:
        self._watch, self._constraints = watch, watch.problem.constraints
        self._every = generations_between_checks(watch.study)
        self._begin: int | None = None

    def left(self, generations: Sequence[Generation]) -> int | None:
        """Return the number of generations left, if the last ones have begun.

        They begin where the search has converged, or has just room for them. The study's budget decides, so a part of a search
        on record is replayed alike.
        """
        budget = self._watch.study.search.budget
        last = budget.generations // GENERATIONS_PER_LAST
        if self._begin is None and last and self._watch.has_flown and has_one(generations[0].evaluation):
            volumes = hypervolumes(list(generations), self.back_off(generations) if budget.converges else None)
            if budget._replace(generations=budget.generations - last).is_met(volumes):
                self._begin = len(generations)
        return None if self._begin is None else max(self._begin + last - len(generations), 0)

    def back_off(self, generations: Sequence[Generation]) -> np.ndarray | None:
        """Return the distances (limits,) by fresh flights so far, if any."""
        return self._added(generations, 0.0) if self._watch.has_flown else None

    def addition(self, generations: Sequence[Generation]) -> np.ndarray | None:
        """Return the addition to the excess (limits,) of all candidates, if any.

        It is that of the next generation.
        """
        if not generations or not any(entry.has_tolerance for entry in self._constraints):
            return None
        is_last = self._begin is not None
        if is_last or len(generations) % self._every == 0:
            seen = concatenate_evaluations([entry.evaluation for entry in generations])
            points = np.concatenate([entry.points for entry in generations])
            self._watch.measure(seen, points, np.arange(len(points)), is_last)
        return self._added(generations, 0.0 if is_last else AIMS[len(generations) % len(AIMS)])

    def _added(self, generations: Sequence[Generation], part: float) -> np.ndarray | None:
        """Return the addition (limits,) of a part of intervals, if any."""
        seen = concatenate_evaluations([entry.evaluation for entry in generations])
        back_off = self._watch.back_off(seen, np.arange(len(seen.values)))
        shift = np.zeros(seen.excess.shape[1])
        for i, distance in enumerate(back_off.shift):
            if not np.isnan(distance):
                shift[i] = distance - 2.0 * part * back_off.width[i]
            elif part:
                shift[i] = part * self._own_width(seen, i)
        return shift if shift.any() else None

    def _own_width(self, seen: Evaluation, i: int) -> float:
        """Return the width of the search's interval, 0 within the limit."""
        front = feasible_front(seen.values, seen.violations)
        _, above = widths(seen, self._constraints, i, self._watch.study.seed, front)
        return float(np.median(above)) if np.any(seen.excess[front, i] + above > 0.0) else 0.0
