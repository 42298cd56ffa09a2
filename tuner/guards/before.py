"""What a study alone lets one foresee."""

from objectives.problem import Objective
from objectives.risk import minimum_samples
from plant.scenarios import HELD_OUT, SEARCH
from tuner.study.study import Study


def few_scenarios(study: Study) -> list[str]:
    """Warn of risks that ask more of the scenarios than there are."""
    return [
        f"{objective.label} rests on {have} {stream} scenarios; {need} would put five into its tail, so expect "
        f"its {stream} value to be optimistic."
        for objective in study.objectives
        for stream in (SEARCH, HELD_OUT)
        if (have := _count(study, objective, stream)) < (need := minimum_samples(objective.risk))
    ]


def _count(study: Study, objective: Objective, stream: str) -> int:
    seen = [entry for entry in study.scenarios if objective.scenario in (None, entry.spec.name)]
    return sum(entry.search if stream == SEARCH else entry.held_out for entry in seen)
