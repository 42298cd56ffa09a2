"""Commands after a run without feasible gains, and sufficient limits."""

from collections.abc import Sequence

import numpy as np

from objectives.evaluator import Constraint, Evaluator, concatenate_evaluations
from plant.seeds import generator
from tuner.analysis.final_flights import FRONT_REPLICATES
from tuner.analysis.limit_flights import spent_confidence
from tuner.documents.parts import LostFlight
from tuner.documents.summary import INFEASIBLE
from tuner.experiments.tuning.conflicts import UpperEnd
from tuner.search.loop import Generation
from tuner.study.own_code import code_named
from tuner.study.searched import SearchedStudy


def rejudge_command(study: SearchedStudy, key: str, value: str) -> str:
    """Return the command that judges recorded flights by another limit."""
    return f"tuner rejudge FOLDER{_code(study)} --set {key}={value} --out NEW"


def fly_command(study: SearchedStudy, flight: LostFlight) -> str:
    """Return the command that repeats a lost flight."""
    scenario = [entry.spec.name for entry in study.scenarios].index(flight.scenario)
    which = f" --scenario {scenario}" if scenario else ""
    return (
        f"tuner fly FOLDER/{INFEASIBLE}{_code(study)} --study FOLDER/inputs/{study.path.stem}.toml{which} "
        f"--flight {flight.name} --plot lost.png"
    )


def _code(study: SearchedStudy) -> str:
    return "".join(f" --code FOLDER/inputs/{name}" for name in code_named(study.content))


def upper_ends(problem: Evaluator, study: SearchedStudy, generations: Sequence[Generation]) -> UpperEnd:
    """Return the upper ends of constraints on the flights of a search."""
    seen = concatenate_evaluations([entry.evaluation for entry in generations])

    def upper_end(candidate: int, i: int) -> float:
        constraint = study.constraints[i]
        scores = seen.scores[candidate, len(problem.objectives) + i]
        name = constraint.objective.scenario
        return upper_end_of(constraint, scores if name is None else scores[seen.origin == name], study.seed)

    return upper_end


def upper_end_of(constraint: Constraint, samples: np.ndarray, root: int) -> float:
    """Return the least limit that samples (flights,) satisfy.

    They satisfy it at the confidence of the constraint, at the first look at them.
    """
    objective = constraint.objective
    if constraint.confidence == 0.0 or objective.risk.name == "worst":
        return float(objective.risk.apply(samples))
    count = len(samples)
    draws = generator(root, "bootstrap/relaxed", 0).integers(count, size=(FRONT_REPLICATES, count), dtype=np.intp)
    return float(objective.interval(samples, draws, spent_confidence(constraint.confidence)).high)
