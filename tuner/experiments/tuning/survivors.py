"""Candidates that survive a search on few flights: they fly all flights of the search, and only they may be recommended.

Every candidate of such a search flies the first scenarios alone. Those that no better one surely beats there, see
`objectives.racing`, and those around a limit that binds make the remaining flights; the front that goes to the held-out check is
theirs.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from objectives.evaluator import OF_CANDIDATES, Evaluation, Evaluator, concatenate_evaluations
from objectives.racing import beaten_by
from tuner.analysis.held_out import SearchEstimate
from tuner.experiments.tuning.active_limits import BackOff, beside_limits
from tuner.experiments.tuning.problem import remaining_batches
from tuner.search.front import non_dominated, select_subset
from tuner.search.infeasible import nothing_feasible
from tuner.search.loop import Generation, archive
from tuner.search.watcher import REFINING, Watcher
from tuner.study.study import SearchedStudy

# Candidates that make all flights at most: as many as are finalists.
MAX_SURVIVORS = 48
# Beside them, those around limits that bind.
MAX_EXTRA_SURVIVORS = 16


@dataclass(frozen=True)
class Survivors:
    """The survivors of a search.

    Attributes:
        candidates: Archive indices (k,) in increasing order, the first of all among them.
        evaluation: Evaluation of these, on all flights of the search.
        flights: Number of flights made for it, the first ones aside.
    """

    candidates: np.ndarray
    evaluation: Evaluation
    flights: int

    def seen(self, candidates: list[int]) -> list[SearchEstimate]:
        """Return survivors by their archive indices as the search saw them."""
        rows, tried = np.searchsorted(self.candidates, candidates).tolist(), self.evaluation
        return [SearchEstimate(tried.values[row], tried.scores[row], tried.origin) for row in rows]


def survivors_of(
    problem: Evaluator,
    study: SearchedStudy,
    generations: list[Generation],
    watcher: Watcher,
    back_off: BackOff | None = None,
) -> Survivors:
    """Fly what survives the search through the rest of its flights; where every candidate flew all of them, all survive."""
    seen = concatenate_evaluations([entry.evaluation for entry in generations])
    if study.search.first is None:
        return Survivors(np.arange(len(seen.values)), seen, 0)
    feasible = surviving(problem, seen, study.seed)
    around = beside_limits(seen, problem.constraints, feasible, study.seed, MAX_EXTRA_SURVIVORS, back_off)
    hopeful = np.concatenate([feasible, around])
    tried = archive(generations)
    hopeful = hopeful if len(hopeful) else [nothing_feasible(tried, study.requirements, study.constraints)[0]]
    candidates = np.union1d([0], hopeful)
    watcher.on_stage(REFINING, len(candidates) * sum(batch.count - batch.start for batch in remaining_batches(study)))
    return flown_through(problem, study, seen, tried.points, candidates, watcher.on_flights_done)


def flown_through(
    problem: Evaluator,
    study: SearchedStudy,
    seen: Evaluation,
    points: np.ndarray,
    candidates: np.ndarray,
    on_flights_done: Callable[[int], None],
) -> Survivors:
    """Fly candidates, increasing archive indices (k,), through the rest of their flights.

    seen: all candidates on the first flights; points (n, d): theirs.
    """
    flown = remaining_batches(study)
    rest = problem.evaluate(points[candidates], flown, on_flights_done, fly_all=candidates == 0)
    if problem.memory:
        problem.memory.commit("survivors")
    return Survivors(candidates, joined(problem, picked(seen, candidates), rest), rest.flights)


def picked(seen: Evaluation, rows: np.ndarray) -> Evaluation:
    """Return the evaluation of some of the candidates."""
    fields = {name: getattr(seen, name)[rows] for name in OF_CANDIDATES}
    return replace(seen, **fields, counted=None if seen.counted is None else seen.counted[rows], failed=None)


def joined(problem: Evaluator, one: Evaluation, other: Evaluation) -> Evaluation:
    """Return the evaluation of candidates on the flights of two; in the order of the scenarios."""
    origin = np.concatenate([one.origin, other.origin])
    names = {name: number for number, name in enumerate(dict.fromkeys(one.origin.tolist()))}
    order = np.argsort([names[name] for name in origin.tolist()], kind="stable")
    scores = np.ascontiguousarray(np.concatenate([one.scores, other.scores], axis=-1)[..., order])
    risks, m = problem.risks(scores, origin[order]), len(problem.objectives)
    excess = np.concatenate([problem.constraint_excess(risks), one.excess[:, len(problem.constraints) :]], axis=1)
    made = one.scores.shape[-1], other.scores.shape[-1]
    failures = (made[0] * one.failures + made[1] * other.failures) / sum(made)
    return replace(
        one,
        values=risks[:, :m],
        excess=excess,
        failures=failures,
        scores=scores,
        origin=origin[order],
        counted=None,
        failed=None,
    )


def surviving(problem: Evaluator, seen: Evaluation, root: int) -> np.ndarray:
    """Return the candidates (k,) within limits that the front does not surely beat.

    The front is among them. If these are too many, those furthest behind are left out, and the last layer is
    thinned.
    """
    feasible = np.flatnonzero(seen.flown & np.all(seen.violations <= 0.0, axis=1))
    if not len(feasible):
        return feasible
    values, m = seen.values[feasible], len(problem.objectives)
    behind = layers(values)
    front = seen.scores[feasible[behind == 0], :m]
    hopeful = (behind == 0) | (beaten_by(problem, front, seen.scores[feasible], seen.origin, root) < 0)
    chosen = list[int]()
    for layer in range(behind.max(initial=0) + 1):
        rows = np.flatnonzero(hopeful & (behind == layer))
        chosen += rows[select_subset(values[rows], seen.values[0], MAX_SURVIVORS - len(chosen))].tolist()
    return np.sort(feasible[chosen])


def layers(values: np.ndarray) -> np.ndarray:
    """Return the non-domination rank (n,) of values (n, m): the number of fronts to remove before it is on one."""
    tried, left = np.zeros(len(values), dtype=int), np.arange(len(values))
    for number in range(len(values)):
        if not len(left):
            break
        front = non_dominated(values[left])
        tried[left[front]] = number
        left = np.delete(left, front)
    return tried
