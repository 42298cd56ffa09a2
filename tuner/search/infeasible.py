"""The nearest candidate of a search in which none kept every limit, and the sentence about it."""

import numpy as np

from objectives.requirements import Requirement
from tuner.search.loop import Archive
from tuner.text.units import after_number

ADVICE = "widen the ranges of the gains, or give the search more generations."


def nothing_feasible(found: Archive, requirements: tuple[Requirement, ...]) -> tuple[int, str]:
    """Return the candidate that breaks least and a sentence on what stood in the way.

    Requirements come first, then constraints: of candidates that were not flown nothing is known of the latter.
    """
    split = found.violations.shape[1] - len(requirements)
    constraints, required = found.violations[:, :split].sum(axis=1), found.violations[:, split:]
    least = int(np.lexsort((constraints, required.sum(axis=1)))[0])
    kept = required <= 0.0
    if not requirements or np.any(np.all(kept, axis=1)):
        why = (
            f"No candidate kept every constraint. The one that breaks them least is shown; relax a constraint, {ADVICE}"
        )
        return least, why
    told = [_told(entry, found.requirements[:, i], kept[:, i]) for i, entry in enumerate(requirements)]
    so = "could be offered" if found.flown[1:].any() else "but the default was flown"
    return least, (
        f"No candidate kept every requirement that is known without flying, so none {so}: {'; '.join(told)}. The one that "
        f"breaks them least is shown; relax a requirement, {ADVICE}"
    )


def _told(requirement: Requirement, values: np.ndarray, kept: np.ndarray) -> str:
    closest = values.min(axis=0) if requirement.sense == "most" else values.max(axis=0)
    unit = after_number(requirement.unit)
    limit = f"{requirement.label} at {requirement.sense} {requirement.limit:.4g}{unit}"
    return f"{limit} was kept by {int(kept.sum(axis=0))} of {len(kept)} candidates, closest {closest:.4g}{unit}"
