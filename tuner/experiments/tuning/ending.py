"""The end of a run: gains to recommend, or nothing that keeps every limit; every other part of the tool asks here."""

from collections.abc import Sequence

import numpy as np

from objectives.problem import Evaluator
from tuner.documents.summary import INFEASIBLE, NOTHING, ObstacleRow
from tuner.experiments.tuning.conflicts import Conflict, Limit, limits_of
from tuner.experiments.tuning.diagnosis import MOST_CANDIDATES, diagnosed, flown_obstacle, obstacle_texts
from tuner.experiments.tuning.outcome import Outcome
from tuner.search.loop import Archive, Generation, point_name
from tuner.study.study import SearchedStudy


def contender_ending(name: str, point: str, obstacles: Sequence[ObstacleRow] = ()) -> list[str]:
    """Return what a contest or comparison says first of a contender whose run found nothing feasible."""
    head = (
        f"{NOTHING} for {name}: nothing that its run tried keeps every limit. It stands here at {point}, which comes nearest, "
        "and no line below recommends it."
    )
    return [head, *[f"{name}: {text}" for text in obstacle_texts(obstacles)]]


def obstacles_of(
    problem: Evaluator, study: SearchedStudy, generations: list[Generation], found: Archive, conflict: Conflict | None,
    limits: list[Limit],
) -> list[ObstacleRow]:  # fmt: skip
    """Return what stands behind each limit of a conflict; nothing where there is none."""
    if conflict is None:
        return []
    split = len(study.constraints)
    named = sorted({i for some in conflict.sets for i in some})
    labels = [limits[i].label for i in named if i >= split]
    nearest = np.argsort(found.violations[:, split:].sum(axis=1), kind="stable")[:MOST_CANDIDATES]
    names = [point_name(int(candidate)) for candidate in nearest]
    known = diagnosed(study, found.points[nearest], names, labels) if labels else []
    complete = np.concatenate([entry.evaluation.complete for entry in generations], axis=0)
    # Of one flown candidate alone, the default, nothing is told where requirements kept all others on the ground.
    if known and complete.sum(axis=0) < 2:
        return known
    return [*known, *_flown(problem, study, generations, found, [i for i in named if i < split])]


def _flown(
    problem: Evaluator, study: SearchedStudy, generations: list[Generation], found: Archive, constraints: list[int]
) -> list[ObstacleRow]:
    complete = np.concatenate([entry.evaluation.complete for entry in generations], axis=0)
    if not constraints or not complete.any():
        return []
    risks = np.concatenate([problem.risks(entry.evaluation.scores, entry.evaluation.origin) for entry in generations])
    values, names = risks[complete, len(study.objectives) :], [point_name(int(i)) for i in np.flatnonzero(complete)]
    return [
        flown_obstacle(study, study.constraints[i], found.points[complete], values[:, i], names) for i in constraints
    ]


def ending_of(outcome: Outcome) -> list[str]:
    """Return what a run that recommends nothing has to say first, the headline before all; nothing for any other run."""
    if outcome.feasible:
        return []
    point = outcome.names[outcome.tuned]
    nearest = f"{point} breaks them least; its gains stand in {INFEASIBLE}, for study and not to be flown."
    about = f"so no gains are recommended. {nearest}"
    if len(outcome.archive.front()) == 0:
        head = f"{NOTHING}: none of {len(outcome.archive.points):,} candidates keeps every limit, {about}"
        return [head, *obstacle_texts(outcome.obstacles)]
    tried = len(outcome.candidates)
    who = "the one finalist does not keep" if tried == 1 else f"none of the {tried} finalists keeps"
    head = f"{NOTHING} on held-out scenarios: {who} every limit there, {about}"
    return [head, f"{point} breaks {'; '.join(_broken(outcome))}.", *_default(outcome)]


def _broken(outcome: Outcome) -> list[str]:
    """Return the limits that the nearest point breaks on held-out scenarios, with its values."""
    study, evaluation, row = outcome.study, outcome.finalists.evaluation, outcome.tuned
    limits, split = limits_of(study.constraints, study.requirements), len(study.constraints)
    broken = np.flatnonzero(evaluation.violations[row] > 0.0).tolist()
    values = [
        limits[i].limit + evaluation.violations[row, i] if i < split else evaluation.requirements[row, i - split]
        for i in broken
    ]
    return [f"{limits[i].text} with {value:.4g}" for i, value in zip(broken, values, strict=True)]


def _default(outcome: Outcome) -> list[str]:
    return ["The default gains keep every limit there."] if outcome.finalists.feasible[0] else []
