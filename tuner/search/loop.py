"""The search loop, written once: ask a generation, fly it, tell, record."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Protocol, runtime_checkable

import numpy as np

from objectives.evaluator import Evaluation, concatenate_evaluations
from tuner.search.convergence import StoppingRule
from tuner.search.front import feasible_front, hypervolume


class Search(Protocol):
    """A search over the unit cube, by generations or parts of them."""

    def ask(self) -> np.ndarray:
        """Return the next points (n, d): first a whole generation, later one or a part of one."""
        ...

    def tell(self, values: np.ndarray, violations: np.ndarray) -> None:
        """Record the objectives (n, m) and constraint violations (n, c) of the pending points.

        Violations are signed: below 0 where there is slack.
        """
        ...


@runtime_checkable
class RevisableSearch(Search, Protocol):
    """A search whose points follow from results, which may be replaced."""

    def retell(self, values: np.ndarray, violations: np.ndarray) -> None:
        """Replace the results of all points so far.

        Objectives (n, m) and constraint violations (n, c) of all points so far; none are pending.
        """
        ...


@runtime_checkable
class ModelSearch(Search, Protocol):
    """A search with models, which are fitted as results grow."""

    def forget_fits(self) -> None:
        """Fit all models from the beginning."""
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
        hypervolume: Hypervolume of the front of all candidates so far, see `tuner.search.front` and `_baseline`.
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


Review = Callable[[Sequence[Generation]], list[Evaluation] | None]
"""All generations so far -> evaluations in place of theirs, on more flights; None where theirs stay."""


class Aim(Protocol):
    """Distances inside limits at which a search looks, None at limits."""

    def addition(self, generations: Sequence[Generation]) -> np.ndarray | None:
        """Return the next generation's addition (limits,) to every excess."""
        ...

    def back_off(self, generations: Sequence[Generation]) -> np.ndarray | None:
        """Return the distances (limits,) by which the front has to be inside."""
        ...

    def left(self, generations: Sequence[Generation]) -> int | None:
        """Return the number of generations left, None where the rule decides."""
        ...


def search_generations(
    search: Search,
    evaluate: Callable[[np.ndarray], Evaluation],
    rule: StoppingRule,
    now: Callable[[], float] | None = None,
    complete: Callable[[Evaluation], Evaluation] | None = None,
    review: Review | None = None,
    aim: Aim | None = None,
) -> Iterator[list[Generation]]:
    """Yield all generations so far, until a search ends.

    The first candidate of all is the baseline of the hypervolume where it is feasible.

    Args:
        search: The search, at its beginning.
        evaluate: Points (n, d) that are asked for -> their evaluation.
        rule: Number of generations.
        now: Seconds since the start of the search, measured here unless given.
        complete: Evaluation of a whole generation -> the one that is recorded, itself unless given.
        review: Evaluates all generations again where it has to; the search goes on from these.
        aim: Distances inside the limits at which the search looks; the front that keeps its back-off has to converge. Points that
            follow from no results have none.
    """
    begin = perf_counter()
    clock = now or (lambda: perf_counter() - begin)
    done: list[Generation] = []
    shift, revisable = None, search if isinstance(search, RevisableSearch) else None
    aim = aim if revisable else None
    while not is_over(done, rule, aim, left := aim.left(done) if aim and done else None):
        if left is not None and isinstance(search, ModelSearch):
            # A fit that begins at one of another aim ends near it. With new fits a hover's objective is 6 % smaller.
            search.forget_fits()
        before, shift = shift, aim.addition(done) if aim else None
        if revisable and (before is not None or shift is not None):
            seen = [entry.evaluation for entry in done]
            revisable.retell(np.concatenate([one.values for one in seen]), _shifted(seen, shift))
        points, evaluation = ask_generation(search, evaluate, len(done[0].points) if done else 1, shift)
        evaluation = complete(evaluation) if complete else evaluation
        done = [*done, record_of(done, points, evaluation, clock())]
        anew = review(done) if review else None
        if anew is not None:
            assert revisable, "only such a search is reviewed"
            revisable.retell(np.concatenate([one.values for one in anew]), _shifted(anew, shift))
            done = recorded_anew(done, anew)
        yield done


def is_over(done: list[Generation], rule: StoppingRule, aim: Aim | None, left: int | None) -> bool:
    """Return True where a search ends: after its last generations, or where the rule is met."""
    if left is not None:
        return left == 0 or len(done) >= rule.generations
    return rule.is_met(hypervolumes(done, aim.back_off(done) if aim and rule.converges else None))


def _shifted(evaluations: Sequence[Evaluation], shift: np.ndarray | None) -> np.ndarray:
    excess = np.concatenate([one.excess for one in evaluations])
    return excess if shift is None else excess + shift


def record_of(before: list[Generation], points: np.ndarray, evaluation: Evaluation, seconds: float) -> Generation:
    """Return the record of a generation after others."""
    every = [*[entry.evaluation for entry in before], evaluation]
    draft = Generation(
        number=len(before),
        points=points,
        evaluation=evaluation,
        flights=sum(entry.flights for entry in every),
        screened=sum(int(np.sum(~entry.flown, axis=0)) for entry in every),
        flights_saved=sum(entry.flights_saved for entry in every),
        raced=sum(int(np.sum(entry.flown & ~entry.complete, axis=0)) for entry in every),
        flights_raced=sum(entry.flights_raced for entry in every),
        seconds=seconds,
        feasible_share=0.0,
        hypervolume=0.0,
    )
    so_far = archive([*before, draft])
    feasible = np.all(so_far.violations <= 0.0, axis=1).mean(axis=0)
    volume = hypervolume(so_far.values[so_far.front()], _baseline(before, so_far))
    return replace(draft, feasible_share=float(feasible), hypervolume=volume)


def _baseline(before: list[Generation], so_far: Archive) -> np.ndarray:
    """Return the baseline (m,) of the hypervolume.

    It stays the same from the first feasible candidate on. It is the default where that is feasible: the box of a default that
    breaks limits may lie far from all that the search finds. Else it is the worst of each objective over the front of the first
    generation with a feasible candidate.
    """
    feasible = np.all(so_far.violations <= 0.0, axis=1)
    if feasible[0] or not feasible.any():
        return so_far.values[0]
    ends = np.cumsum([len(entry.points) for entry in before])
    first = int(np.flatnonzero(feasible)[0])
    end = next((int(end) for end in ends if first < end), len(so_far.values))
    values = so_far.values[:end]
    return values[feasible_front(values, so_far.violations[:end])].max(axis=0)


def hypervolumes(generations: list[Generation], back_off: np.ndarray | None) -> list[float]:
    """Return the hypervolumes, one a generation, behind a back-off (limits,)."""
    if back_off is not None:
        seen = [entry.evaluation for entry in generations]
        generations = recorded_anew(generations, [replace(one, excess=one.excess + back_off) for one in seen])
    return [record.hypervolume for record in generations]


def recorded_anew(generations: list[Generation], evaluations: list[Evaluation]) -> list[Generation]:
    """Return generations with other evaluations; each counts the flights that it had made when it was recorded."""
    done: list[Generation] = []
    for entry, evaluation in zip(generations, evaluations, strict=True):
        record = record_of(done, entry.points, evaluation, entry.seconds)
        last = entry is generations[-1]
        done.append(record if last else replace(record, flights=entry.flights))
    return done


def ask_generation(
    search: Search, evaluate: Callable[[np.ndarray], Evaluation], population: int, shift: np.ndarray | None = None
) -> tuple[np.ndarray, Evaluation]:
    """Return the points (n, d) of the next generation and their evaluation.

    population: least n; shift (limits,): added to its excess in the search.
    """
    points, evaluations, count = [], [], 0
    while count < population:
        points.append(search.ask())
        evaluations.append(evaluate(points[-1]))
        search.tell(evaluations[-1].values, _shifted(evaluations[-1:], shift))
        count += len(points[-1])
    return np.concatenate(points), concatenate_evaluations(evaluations)


def point_name(candidate: int) -> str:
    """Return the name of a candidate in tables and reports."""
    return f"p{candidate:04d}"
