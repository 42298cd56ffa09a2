"""How a run ended: with gains to recommend, or with nothing that keeps every limit; every other part of the tool asks here."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from objectives.problem import Problem
from plant.input_files import read_input_text
from tuner.experiments.tuning.conflicts import Conflict, Limit
from tuner.experiments.tuning.diagnosis import MOST_CANDIDATES, Diagnosis, Obstacle, flown_obstacle, told_obstacles
from tuner.experiments.tuning.tables import point_name
from tuner.search.loop import Archive, Generation
from tuner.study.study import Study

if TYPE_CHECKING:
    from tuner.experiments.tuning.conclusion import Outcome

GAINS, INFEASIBLE = "gains.json", "infeasible.json"
"""Where a run leaves its recommended gains, and where those of the nearest point if nothing was feasible."""
NOTHING = "Nothing feasible"
"""What the first line begins with wherever a run that recommends nothing is told."""


def is_feasible(summary: Mapping[str, Any]) -> bool:
    """Return whether the summary of a run recommends anything; folders of earlier versions tell it by their conflict."""
    return bool(summary.get("feasible", summary.get("conflict") is None))


def shown_point(summary: Mapping[str, Any]) -> str:
    """Return the point that stands beside the default: the recommended one, else the nearest to feasible."""
    return str(summary["tuned"] if summary.get("tuned") is not None else summary["nearest"])


def shown_as(summary: Mapping[str, Any]) -> str:
    """Return what that point is called at the head of a column."""
    return "tuned" if is_feasible(summary) else "nearest"


def gains_name(feasible: bool) -> str:
    """Return the name of the file that a run leaves the gains of that point in."""
    return GAINS if feasible else INFEASIBLE


def gains_file(summary: Mapping[str, Any]) -> str:
    """Return the name of that file in a folder with this summary; those of earlier versions have but one."""
    return gains_name(summary.get("feasible", True))


def is_recommended(file: Path) -> bool:
    """Return whether a gains file that can be read says nothing against being flown."""
    return bool(json.loads(read_input_text(file)).get("study", {}).get("feasible", True))


def contender_ending(name: str, point: str, obstacles: Sequence[Obstacle] = ()) -> list[str]:
    """Return what a contest or comparison says first of a contender whose run found nothing feasible."""
    head = (
        f"{NOTHING} for {name}: nothing that its run tried keeps every limit. It stands here at {point}, which comes nearest, "
        "and no line below recommends it."
    )
    return [head, *[f"{name}: {text}" for text in told_obstacles(obstacles)]]


def obstacles_of(
    problem: Problem, study: Study, generations: list[Generation], found: Archive, conflict: Conflict | None,
    limits: list[Limit],
) -> list[Obstacle]:  # fmt: skip
    """Return what stands behind each limit of a conflict; nothing where there is none."""
    if conflict is None:
        return []
    split = len(study.constraints)
    named = sorted({i for some in conflict.sets for i in some})
    labels = [limits[i].label for i in named if i >= split]
    nearest = np.argsort(found.violations[:, split:].sum(axis=1), kind="stable")[:MOST_CANDIDATES]
    names = [point_name(int(candidate)) for candidate in nearest]
    known = Diagnosis(study).obstacles(found.points[nearest], names, labels) if labels else []
    complete = np.concatenate([entry.evaluation.complete for entry in generations], axis=0)
    # Of one flown candidate alone, the default, nothing is told where requirements kept all others on the ground.
    if known and complete.sum(axis=0) < 2:
        return known
    return [*known, *_flown(problem, study, generations, found, [i for i in named if i < split])]


def _flown(
    problem: Problem, study: Study, generations: list[Generation], found: Archive, constraints: list[int]
) -> list[Obstacle]:
    complete = np.concatenate([entry.evaluation.complete for entry in generations], axis=0)
    if not constraints or not complete.any():
        return []
    risks = np.concatenate([problem.risks(entry.evaluation.scores, entry.evaluation.origin) for entry in generations])
    values, names = risks[complete, len(study.objectives) :], [point_name(int(i)) for i in np.flatnonzero(complete)]
    return [
        flown_obstacle(study, study.constraints[i], found.points[complete], values[:, i], names) for i in constraints
    ]


def ending_of(outcome: "Outcome") -> list[str]:
    """Return what a run that recommends nothing has to say first, the headline before all; nothing for any other run."""
    if outcome.feasible:
        return []
    point = outcome.names[outcome.tuned]
    nearest = f"{point} breaks them least; its gains stand in {INFEASIBLE}, for study and not to be flown."
    about = f"so no gains are recommended. {nearest}"
    if len(outcome.archive.front()) == 0:
        head = f"{NOTHING}: none of {len(outcome.archive.points):,} candidates keeps every limit, {about}"
        return [head, *told_obstacles(outcome.obstacles)]
    tried = len(outcome.candidates)
    who = "the one finalist does not keep" if tried == 1 else f"none of the {tried} finalists keeps"
    head = f"{NOTHING} on held-out scenarios: {who} every limit there, {about}"
    return [head, f"{point} breaks {'; '.join(_broken(outcome))}.", *_default(outcome)]


def _broken(outcome: "Outcome") -> list[str]:
    """Return the limits that the nearest point breaks on held-out scenarios, with its values."""
    from tuner.experiments.tuning.conflicts import limits_of

    study, evaluation, row = outcome.study, outcome.finalists.evaluation, outcome.tuned
    limits, split = limits_of(study.constraints, study.requirements), len(study.constraints)
    broken = np.flatnonzero(evaluation.violations[row] > 0.0).tolist()
    values = [
        limits[i].limit + evaluation.violations[row, i] if i < split else evaluation.requirements[row, i - split]
        for i in broken
    ]
    return [f"{limits[i].said()} with {value:.4g}" for i, value in zip(broken, values, strict=True)]


def _default(outcome: "Outcome") -> list[str]:
    return ["The default gains keep every limit there."] if outcome.finalists.feasible[0] else []
