"""A peer for tests: asks what is known of points before it proposes them, and fails when it is told so."""

import numpy as np

from benchmarks.search.peer import Start


class Halving:
    """Proposes points halfway to the best so far, those first that keep what is known."""

    def __init__(self, start: Start) -> None:
        self._start, self._asked = start, start.first
        self._best = start.first[0]
        self._draw = np.random.default_rng(start.seed)

    def ask(self):
        return self._asked

    def tell(self, values, violations):
        print("what a library prints is no answer")
        if np.any(values < 0.0):
            raise ValueError("values are above 0")
        best = int(np.argmin(values.sum(axis=1) + violations.sum(axis=1)))
        self._best = self._asked[best]
        pool = (self._draw.uniform(size=(4 * self._start.batch, len(self._best))) + self._best) / 2.0
        order = np.argsort(self._start.excess(pool).max(axis=1), kind="stable")
        self._asked = pool[order[: self._start.batch]]


def begun(start: Start) -> Halving:
    return Halving(start)
