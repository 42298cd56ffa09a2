"""A run of a search on a published problem: batches are evaluated until the budget is spent, and scored afterwards."""

from collections.abc import Callable
from time import process_time
from typing import NamedTuple

import numpy as np

from benchmarks.search.peer import Array, Search
from benchmarks.search.process import PeerFailed
from benchmarks.search.published.problem import PublishedProblem
from benchmarks.search.published.reference import score
from benchmarks.search.published.suite import SUITE
from plant.seeds import generator
from tuner.search.front import feasible_front
from tuner.search.initial_design import latin_hypercube

# Evaluations between two scores, and of the first batch.
STEP = 12
EVALUATIONS = 300
# Marks of the table, and the evaluations whose score stands there: the last multiple of the step.
MARKS = (50, 100, 144, 300)

SearchFactory = Callable[[Array, int, int, int], Search]
"""First points (n, d), number of objectives, number of constraints, seed -> search."""


class RunKey(NamedTuple):
    """Name of a run."""

    problem: str
    contestant: str
    seed: int


class PublishedRun(NamedTuple):
    """A run: scores after every `STEP` evaluations, processor seconds, and why it ended early ("" where it did not)."""

    scores: list[float | None]
    seconds: float
    stopped: str

    def score_at(self, evaluations: int) -> float | None:
        """Return the score after so many evaluations, that of its end where it ended early."""
        rows = self.scores[: evaluations // STEP]
        return rows[-1] if rows else None


class Evaluations:
    """All evaluations of a run, in order."""

    def __init__(self, problem: PublishedProblem, seed: int) -> None:
        self._problem, self._noise = problem, generator(seed, "published/noise", 0)
        shape = problem.n_objectives
        self._values, self._observed = np.empty((0, shape)), np.empty((0, shape))
        self._constraints = np.empty((0, problem.n_constraints))

    def __len__(self) -> int:
        return len(self._values)

    def add(self, points: Array) -> tuple[Array, Array]:
        """Evaluate points (n, d); return observed objectives (n, m) and constraint values (n, c)."""
        values, constraints = self._problem.evaluate(points)
        observed = self._problem.disturb(values, self._noise)
        self._values = np.concatenate([self._values, values])
        self._observed = np.concatenate([self._observed, observed])
        self._constraints = np.concatenate([self._constraints, constraints])
        return observed, constraints

    def scores(self, name: str) -> list[float | None]:
        """Return the score after every `STEP` evaluations: of the exact values of the observed front."""
        scores: list[float | None] = []
        for count in range(STEP, len(self) + 1, STEP):
            front = feasible_front(self._observed[:count], np.maximum(self._constraints[:count], 0.0))
            value = score(name, self._values[front], self._constraints[front])
            scores.append(None if value is None else float(f"{value:.5g}"))
        return scores


def first_points(name: str, seed: int, count: int = STEP) -> Array:
    """Return the first points (count, d) of a run: a Latin hypercube, the same for every search."""
    return latin_hypercube(count, SUITE[name].dimension, generator(seed, f"published/{name}", 0))


def play(
    factory: SearchFactory,
    name: str,
    seed: int,
    evaluations: int = EVALUATIONS,
    batch: int = STEP,
    max_seconds: float = np.inf,
) -> PublishedRun:
    """Return the run of a search on a problem.

    Args:
        factory: Constructor of the search.
        name: Name of the problem.
        seed: Seed of the first points, of the noise and of the search.
        evaluations: Number of evaluations.
        batch: Number of first points, which is the batch of the tool's searches.
        max_seconds: Processor seconds after which the run is stopped; of this process unless the search has `seconds`.
    """
    problem, begin = SUITE[name], process_time()
    done, seconds = Evaluations(problem, seed), 0.0
    search = factory(first_points(name, seed, batch), problem.n_objectives, problem.n_constraints, seed)
    stopped = ""
    while len(done) < evaluations and not stopped:
        try:
            points = search.ask()[: evaluations - len(done)]
            observed, constraints = done.add(points)
            if len(done) < evaluations:
                search.tell(observed, constraints)
            stopped = "" if len(points) else "it proposes nothing new"
        except PeerFailed as error:
            stopped = str(error)
        seconds = getattr(search, "seconds", process_time() - begin)
        if seconds > max_seconds:
            stopped = f"ended by its budget of {max_seconds:g} s"
    return PublishedRun(done.scores(name), round(seconds, 2), stopped if len(done) < evaluations else "")
