"""Distance inside binding limits at which the generations of a search aim.

A model-based search is told the excess over each limit. Told a little more of it, it looks for points further inside, and the
held-out check finds points on both sides of the limit that it judges by.
"""

from collections.abc import Sequence
from math import ceil

import numpy as np

from objectives.evaluator import Evaluation, concatenate_evaluations
from tuner.experiments.tuning.active_limits import has_tolerance, widths
from tuner.experiments.tuning.limit_watch import LimitWatch
from tuner.search.front import feasible_front
from tuner.search.loop import Generation

AIMS = (0.0, 0.25, 0.5)
"""Parts of an interval by which generations, one after the other, aim further inside, or further outside of a back-off."""
WATCH_EVERY = 32
"""Candidates from one look at fresh flights to the next."""


class LimitAim:
    """Addition to the excess of all candidates, by generation.

    Args:
        watch: Measures the back-off from limits by fresh flights.
    """

    def __init__(self, watch: LimitWatch) -> None:
        self._watch, self._constraints = watch, watch.problem.constraints
        self._every = ceil(WATCH_EVERY / watch.study.search.population)

    def __call__(self, generations: Sequence[Generation]) -> np.ndarray | None:
        """Return the addition to the excess (limits,) of all candidates, if any.

        It is that of the next generation.
        """
        if not generations or not any(map(has_tolerance, self._constraints)):
            return None
        seen, part = (
            concatenate_evaluations([entry.evaluation for entry in generations]),
            AIMS[len(generations) % len(AIMS)],
        )
        candidates = np.arange(len(seen.values))
        if len(generations) % self._every == 0:
            self._watch.measure(seen, np.concatenate([entry.points for entry in generations]), candidates)
        back_off = self._watch.back_off(seen, candidates)
        shift = np.concatenate(
            [back_off.shift - 2.0 * part * back_off.width, np.zeros(seen.excess.shape[1] - len(back_off.shift))]
        )
        for i in np.flatnonzero(np.isnan(back_off.shift)):
            shift[i] = part * self._own_width(seen, int(i)) if part else 0.0
        return shift if shift.any() else None

    def _own_width(self, seen: Evaluation, i: int) -> float:
        """Return the width of the search's interval, 0 within the limit."""
        front = feasible_front(seen.values, seen.violations)
        _, above = widths(seen, self._constraints, i, self._watch.study.seed)
        return float(np.median(above[front])) if np.any(seen.excess[front, i] + above[front] > 0.0) else 0.0
