"""The least violating candidate of an infeasible search."""

from collections.abc import Sequence

import numpy as np

from objectives.evaluator import Constraint, relative_excess
from objectives.requirements import Requirement
from tuner.search.loop import Archive
from tuner.text.sentences import BOUNDS
from tuner.text.units import after_number


def nothing_feasible(
    candidates: Archive, requirements: tuple[Requirement, ...], constraints: Sequence[Constraint] = ()
) -> tuple[int, list[str]]:
    """Return the least violating candidate, and a sentence on unsatisfied requirements.

    Requirements come first, then constraints: of candidates that were not flown nothing is known of the latter. Each counts
    relative to its limit. There is no sentence where some candidate satisfies all requirements.
    """
    split = candidates.violations.shape[1] - len(requirements)
    violations = relative_excess(constraints, candidates.violations)
    flown, required = violations[:, :split].sum(axis=1), violations[:, split:]
    least = int(np.lexsort((flown, required.sum(axis=1)))[0])
    is_satisfied = required <= 0.0
    if not requirements or np.any(np.all(is_satisfied, axis=1)):
        return least, []
    counts = [
        _count_text(requirement, candidates.requirements[:, i], is_satisfied[:, i])
        for i, requirement in enumerate(requirements)
    ]
    so = "could be offered" if candidates.flown[1:].any() else "but the default was flown"
    why = f"No candidate kept every requirement that is known without flying, so none {so}: {'; '.join(counts)}."
    return least, [why]


def _count_text(requirement: Requirement, values: np.ndarray, is_satisfied: np.ndarray) -> str:
    closest = values.min(axis=0) if requirement.sense == "max" else values.max(axis=0)
    unit = after_number(requirement.unit)
    limit = f"{requirement.label} {BOUNDS[requirement.sense]} {requirement.limit:.4g}{unit}"
    count = f"{int(is_satisfied.sum(axis=0))} of {len(values)} candidates"
    return f"{limit} was kept by {count}, closest {closest:.4g}{unit}"
