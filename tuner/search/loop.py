"""The search loop, written once: ask a generation, fly it, tell, record."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Protocol

import numpy as np

from objectives.evaluator import Evaluation, concatenate_evaluations
from tuner.search.convergence import StoppingRule
from tuner.search.front import feasible_front, hypervolume


class Search(Protocol):
    """A search over the unit cube, a generation or a part of one at a time."""

    def ask(self) -> np.ndarray:
        """Return the next points (n, d): first a whole generation, later one or a part of one."""
        ...

    def tell(self, values: np.ndarray, violations: np.ndarray) -> None:
        """Record the objectives (n, m) and constraint violations (n, c) of the pending points.

        Violations are signed: below 0 where there is slack.
        """
        ...


@dataclass(frozen=True)
class Generation:
    """One generation and the state of the search after it.

    Attributes:
        points: Points (n, d).
        evaluation: Evaluation of these points.
        flights: Number of flights from the start of the search.
        screened: Number of candidates not flown so far.
        flights_saved: Number of flights saved by them.
        raced: Number of candidates that a race ended early so far.
        flights_raced: Number of flights spared by that.
        seconds: Time from the start of the search [s].
        feasible_share: Feasible share of all candidates so far.
        hypervolume: Hypervolume of the front of all candidates so far, see `tuner.search.front`.
    """

    number: int
    points: np.ndarray
    evaluation: Evaluation
    flights: int
    screened: int
    flights_saved: int
    raced: int
    flights_raced: int
    seconds: float
    feasible_share: float
    hypervolume: float


@dataclass(frozen=True)
class Archive:
    """All candidates of a search in order: points (n, d), values (n, m), violations (n, c).

    requirements (n, r), flown (n,): as in `Evaluation`.
    """

    points: np.ndarray
    values: np.ndarray
    violations: np.ndarray
    requirements: np.ndarray
    flown: np.ndarray

    def front(self) -> np.ndarray:
        """Return the indices of the feasible, non-dominated candidates."""
        return feasible_front(self.values, self.violations)


def archive(generations: list[Generation]) -> Archive:
    """Return all candidates of the generations."""
    evaluations = [generation.evaluation for generation in generations]
    names = ("values", "violations", "requirements", "flown")
    columns = [np.concatenate([getattr(part, name) for part in evaluations], axis=0) for name in names]
    return Archive(np.concatenate([generation.points for generation in generations], axis=0), *columns)


def search_generations(
    search: Search,
    evaluate: Callable[[np.ndarray], Evaluation],
    rule: StoppingRule,
    now: Callable[[], float] | None = None,
    complete: Callable[[Evaluation], Evaluation] | None = None,
) -> Iterator[Generation]:
    """Yield the generations of a search until its stopping rule is met.

    The first candidate of all is the baseline of the hypervolume.

    Args:
        search: The search, at its beginning.
        evaluate: Points (n, d) that are asked for -> their evaluation.
        rule: Number of generations.
        now: Seconds since the start of the search, measured here unless given.
        complete: Evaluation of a whole generation -> the one that is recorded, itself unless given.
    """
    begin = perf_counter()
    clock = now or (lambda: perf_counter() - begin)
    done: list[Generation] = []
    flights = screened = saved = raced = spared = 0
    while not rule.is_met([record.hypervolume for record in done]):
        points, evaluation = ask_generation(search, evaluate, len(done[0].points) if done else 1)
        evaluation = complete(evaluation) if complete else evaluation
        flights += evaluation.flights
        screened += int(np.sum(~evaluation.flown, axis=0))
        saved += evaluation.flights_saved
        raced += int(np.sum(evaluation.flown & ~evaluation.complete, axis=0))
        spared += evaluation.flights_raced
        draft = Generation(len(done), points, evaluation, flights, screened, saved, raced, spared, clock(), 0.0, 0.0)
        so_far = archive([*done, draft])
        feasible = np.all(so_far.violations <= 0.0, axis=1).mean(axis=0)
        volume = hypervolume(so_far.values[so_far.front()], so_far.values[0])
        record = replace(draft, feasible_share=float(feasible), hypervolume=volume)
        done.append(record)
        yield record


def ask_generation(
    search: Search, evaluate: Callable[[np.ndarray], Evaluation], population: int
) -> tuple[np.ndarray, Evaluation]:
    """Return the points (n, d) of the next generation and their evaluation, n at least the population."""
    points, evaluations, count = [], [], 0
    while count < population:
        points.append(search.ask())
        evaluations.append(evaluate(points[-1]))
        search.tell(evaluations[-1].values, evaluations[-1].excess)
        count += len(points[-1])
    return np.concatenate(points), concatenate_evaluations(evaluations)


def point_name(candidate: int) -> str:
    """Return the name of a candidate in tables and reports."""
    return f"p{candidate:04d}"
