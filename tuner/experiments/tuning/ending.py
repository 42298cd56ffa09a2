"""The end of a run: gains to recommend, or nothing that keeps every limit; every other part of the tool uses this."""

from collections.abc import Sequence
from math import ceil, floor, log10
from typing import cast

import numpy as np

from objectives.problem import Evaluator
from plant.quadrotor.scenarios import HELD_OUT
from plant.ties import increasing_order
from tuner.analysis.lost_flights import named_losses
from tuner.documents.obstacles import UnmetConstraint
from tuner.documents.summary import INFEASIBLE, NOTHING, ComparedRow
from tuner.experiments.tuning.conflicts import Conflict, Limit, limits_of
from tuner.experiments.tuning.diagnosis import MAX_CANDIDATES, Diagnosis, flown_obstacle, obstacle_texts
from tuner.experiments.tuning.next_commands import fly_command, rejudge_command, upper_end_of
from tuner.experiments.tuning.outcome import Outcome
from tuner.experiments.tuning.problem import batches
from tuner.search.loop import Archive, Generation, point_name
from tuner.study.study import SearchedStudy, Study
from tuner.text.numbers import significant

# Lost flights told by name at most.
MAX_LOST = 3


def contender_ending(name: str, point: str, obstacles: Sequence[UnmetConstraint] = ()) -> list[str]:
    """Return the headline on a contender whose run found nothing feasible."""
    head = (
        f"{NOTHING} for {name}: nothing that its run tried satisfies every limit. {point}, which comes nearest, "
        "stands here, and no line below recommends it."
    )
    return [head, *[f"{name}: {text}" for text in obstacle_texts(obstacles)]]


def obstacles_of(
    problem: Evaluator,
    study: SearchedStudy,
    generations: list[Generation],
    explored: Archive,
    conflict: Conflict | None,
    limits: list[Limit],
) -> list[UnmetConstraint]:
    """Return the diagnosis of each limit of a conflict; nothing where there is none."""
    if conflict is None:
        return []
    split = len(study.constraints)
    named = sorted({i for some in conflict.sets for i in some})
    labels = [limits[i].label for i in named if i >= split]
    nearest = increasing_order(explored.violations[:, split:].sum(axis=1))[:MAX_CANDIDATES]
    names = [point_name(int(candidate)) for candidate in nearest]
    known_obstacles = list[UnmetConstraint]()
    if labels and study.loop_requirements() is not None:
        known_obstacles = Diagnosis(cast(Study, study)).obstacles(explored.points[nearest], names, labels)
    complete = np.concatenate([entry.evaluation.complete for entry in generations], axis=0)
    # Of one flown candidate alone, the default, nothing is told where requirements kept all others on the ground.
    if known_obstacles and complete.sum(axis=0) < 2:
        return known_obstacles
    return [*known_obstacles, *_flown(problem, study, generations, explored, [i for i in named if i < split])]


def _flown(
    problem: Evaluator, study: SearchedStudy, generations: list[Generation], explored: Archive, constraints: list[int]
) -> list[UnmetConstraint]:
    complete = np.concatenate([entry.evaluation.complete for entry in generations], axis=0)
    if not constraints or not complete.any():
        return []
    risks = np.concatenate([problem.risks(entry.evaluation.scores, entry.evaluation.origin) for entry in generations])
    values, names = risks[complete, len(study.objectives) :], [point_name(int(i)) for i in np.flatnonzero(complete)]
    return [
        flown_obstacle(study, study.constraints[i], explored.points[complete], values[:, i], names) for i in constraints
    ]


def ending_of(outcome: Outcome) -> list[str]:
    """Return headline and reasons of a run that recommends nothing; nothing for any other run."""
    if outcome.feasible:
        return []
    point = outcome.names[outcome.tuned]
    nearest = f"The nearest point ({point}) violates them least; its gains are in {INFEASIBLE}, for study and not to be flown."
    about = f"so no gains are recommended. {nearest}"
    if len(outcome.archive.front()) == 0:
        head = f"{NOTHING}: none of {len(outcome.archive.points):,} candidates satisfies every limit, {about}"
        return [head, *obstacle_texts(outcome.obstacles)]
    if outcome.finalists.feasible[outcome.tuned]:
        return _broken_again(outcome, point)
    if outcome.to_settle is not None:
        return [_unsettled(outcome, point, outcome.to_settle)]
    tried = len(outcome.candidates)
    who = "the one finalist does not satisfy" if tried == 1 else f"none of the {tried} finalists satisfies"
    head = f"{NOTHING} on held-out scenarios: {who} every limit there, {about}"
    violated = f"{point} violates {'; '.join(_broken(outcome))}."
    return [head, violated, *_lost(outcome, point)]


def _unsettled(outcome: Outcome, point: str, flights: int) -> str:
    """Return the text on a nearest point within its limits by value."""
    study = outcome.study
    broken = np.flatnonzero(outcome.finalists.excess[outcome.tuned] > 0.0)
    broken_text = "; ".join(_broken(outcome))
    confidence = 100.0 * max(study.constraints[i].confidence for i in broken)
    return (
        f"{NOTHING} with {confidence:g} % confidence: {point} is nearest and within every limit by its values, but an interval "
        f"reaches beyond one: {broken_text}. About {flights:,} held-out flights would settle it; raise held_out, or "
        f"`{rejudge_command(study, 'confidence', '0')}` judges by the values alone. Its gains are in {INFEASIBLE}, for study and "
        "not to be flown."
    )


def _broken(outcome: Outcome) -> list[str]:
    """Return the nearest point's broken limits on held-out scenarios, with values."""
    study, finalists, row = outcome.study, outcome.finalists, outcome.tuned
    limits, split = limits_of(study.constraints, study.requirements), len(study.constraints)
    texts = []
    for i in np.flatnonzero(finalists.excess[row] > 0.0).tolist():
        if i >= split:
            shown_value = f"{finalists.evaluation.requirements[row, i - split]:.4g}"
        elif study.constraints[i].rests_on_value:
            shown_value = f"{limits[i].limit + finalists.excess[row, i]:.4g}"
        else:
            shown_value = _estimate(finalists.limits[:, row, i])
        texts.append(f"{limits[i].text} with {shown_value}")
    return texts


def _estimate(ends: np.ndarray) -> str:
    value, low, high = (significant(float(part)) for part in ends)
    return f"{value} [{low}, {high}]"


def _lost(outcome: Outcome, point: str) -> list[str]:
    """Return the nearest point's lost flights, and commands for them."""
    study, row, flown = outcome.study, outcome.tuned, outcome.finalists.flown
    limited = [
        i
        for i, entry in enumerate(study.constraints)
        if entry.objective.metric.metric.name == "failure" and outcome.finalists.excess[row, i] > 0.0
    ]
    if not limited:
        return []
    lost = named_losses(outcome.problem, outcome.gains(row), batches(study, HELD_OUT), flown.failed[row], "")
    if not lost:
        return []
    names = "; ".join(entry.words for entry in lost[:MAX_LOST])
    more = int(flown.failed[row].sum(axis=0)) - len(lost[:MAX_LOST])
    column = len(study.objectives) + limited[0]
    enough = upper_end_of(study.constraints[limited[0]], outcome.finalists.evaluation.scores[row, column], study.seed)
    fly, rejudge = fly_command(study, lost[0]), rejudge_command(study, f"constraint.{limited[0]}.max", _ceiled(enough))
    return [
        f"{point} lost {names}{f' and {more} more' if more > 0 else ''}. `{fly}` draws the first; "
        f"`{rejudge}` judges by a limit that has room for the lost."
    ]


def _ceiled(share: float) -> str:
    """Return a share with two digits, rounded up."""
    step = 10.0 ** (floor(log10(share)) - 1)
    return f"{ceil(share / step) * step:.2g}"


def _broken_again(outcome: Outcome, point: str) -> list[str]:
    """Return the text on limits broken on confirmation flights alone."""
    study, broken = outcome.study, outcome.broken_again.tolist()
    limits = limits_of(study.constraints, study.requirements)
    rows = [outcome.table[len(study.objectives) + i] for i in broken]
    values = [f"{limits[i].text} with {_shown(row)}" for i, row in zip(broken, rows, strict=True)]
    head = (
        f"{NOTHING} on confirmation scenarios: {point} satisfies every limit on held-out ones, by which it was picked, and "
        f"violates {'; '.join(values)} on these, so no gains are recommended. Its gains are in {INFEASIBLE}, for study and "
        "not to be flown."
    )
    return [head, *[_rejudged(study, limits[i], i, row) for i, row in zip(broken, rows, strict=True)]]


def _shown(row: ComparedRow) -> str:
    value, low, high = (significant(part) for part in row.tuned.parts)
    return f"{value} [{low}, {high}]" if row.tuned_count is None else f"{row.tuned_count.words} flights"


def _rejudged(study: SearchedStudy, limit: Limit, index: int, row: ComparedRow) -> str:
    key = limit.automatic or f"constraint.{index}.max"
    smaller = f"a smaller {key} picks a point that lies further from this limit, and " if limit.limit > 0.0 else ""
    # An automatic limit is a share of an error that the key does not tell.
    larger = "a larger one" if limit.automatic else f"one of about {significant(row.tuned.high, 2)} or more"
    return (
        f"`{rejudge_command(study, key, 'VALUE')}` judges the flights already flown by another limit: {smaller}"
        f"{larger} has room for this point."
    )
