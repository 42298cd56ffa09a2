"""NOMAD: mesh adaptive direct search, DMulti-MADS for two objectives, constraints by its progressive barrier.

C. Audet, S. Le Digabel, V. Rochon Montplaisir, C. Tribes, "Algorithm 1027: NOMAD version 4", ACM Transactions on Mathematical
Software 48(3):35, 2022; PyNomadBBO 4.6. It calls for values, so it runs in a thread of its own that waits for them.
"""

from queue import Queue
from threading import Thread

import numpy as np
import PyNomad

from benchmarks.search.peer import Array, Start

MAX_EVALUATIONS = 100_000


def begun(start: Start) -> "DirectSearch":
    """Return the search at its beginning."""
    return DirectSearch(start)


class DirectSearch:
    """A direct search from the best of the first points on, one point after the other."""

    def __init__(self, start: Start) -> None:
        self._start = start
        self._pending = start.first
        self._points: Queue[Array | None] = Queue()
        self._results: Queue[bytes] = Queue()
        # The value of the point that NOMAD starts from and asks for first, which is known.
        self._first_result, self._is_begun = b"", False

    def ask(self) -> Array:
        """Return the first points (n, d), then one point (1, d), none where the search has ended."""
        if not len(self._pending):
            point = self._points.get()
            self._pending = np.empty((0, self._start.first.shape[1])) if point is None else point[None]
        return self._pending

    def tell(self, values: Array, violations: Array) -> None:
        """Tell objectives (n, m) and constraint values (n, c) of the points."""
        self._pending = self._pending[:0]
        results = [" ".join(map(repr, row)).encode() for row in np.concatenate([values, violations], axis=1).tolist()]
        if self._first_result:
            self._results.put(results[0])
            return
        best = best_row(values, violations)
        self._first_result = results[best]
        Thread(target=self._run, args=(self._start.first[best].tolist(),), daemon=True).start()

    def _run(self, point: list[float]) -> None:
        start, dimension = self._start, self._start.first.shape[1]
        options = [
            "BB_OUTPUT_TYPE " + " ".join(["OBJ"] * start.objectives + ["PB"] * start.limits),
            f"MAX_BB_EVAL {MAX_EVALUATIONS}",
            f"SEED {start.seed}",
            "DISPLAY_DEGREE 0",
            "NB_THREADS_PARALLEL_EVAL 1",
        ]
        if start.objectives > 1:
            options += ["DMULTIMADS_OPTIMIZATION true", "DIRECTION_TYPE ORTHO 2N", "QUAD_MODEL_SEARCH false"]
        PyNomad.optimize(self._evaluate, point, [0.0] * dimension, [1.0] * dimension, options)
        self._points.put(None)

    def _evaluate(self, point: "PyNomad.PyNomadEvalPoint") -> int:
        if self._is_begun:
            self._points.put(np.array([point.get_coord(i) for i in range(point.size())]))
        point.setBBO(self._results.get() if self._is_begun else self._first_result)
        self._is_begun = True
        return 1


def best_row(values: Array, violations: Array) -> int:
    """Return the row of the least violation, then of the least sum of ranks of the objectives."""
    ranks = np.argsort(np.argsort(values, axis=0, kind="stable"), axis=0, kind="stable").sum(axis=1)
    return int(np.lexsort((ranks, np.maximum(violations, 0.0).sum(axis=1)))[0])
