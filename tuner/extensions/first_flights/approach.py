"""The way from the gains that a vehicle flies to tuned ones: few enough steps to fly, small enough to be undone in the air.

A gain that keeps its sign goes by equal factors, others by equal differences. On the way a margin may be as low as its usual
limit, or as low as at the worse of both ends, and no lower.
"""

from math import ceil, isfinite, log

import numpy as np

from objectives.margins.quantities import QUANTITIES
from plant.errors import InputError
from tuner.analysis.margins.document import limited_row
from tuner.analysis.margins.limits import LIMITS, LoopLimit
from tuner.analysis.margins.readings import Subject
from tuner.documents.margins import LimitRow

Array = np.ndarray
# A gain changes by at most half in a step, unless that takes too many; most steps where the size of one is given.
MAX_FACTOR, MAX_STEPS = 1.5, 8
MAX_STEPS_OPTION = 32
# Least and largest share of itself by which a gain may be asked to change in a step.
STEP_SHARES = (0.05, 1.0)
# Relative; a margin that is the same at both ends must not fall short by rounding on the way.
ROUNDING = 1e-9


def steps_between(present: Array, tuned: Array) -> int:
    """Return the number of steps from one gains row (g,) to another."""
    return min(steps_of_factor(present, tuned, MAX_FACTOR), MAX_STEPS)


def steps_of_size(present: Array, tuned: Array, share: float) -> int:
    """Return the number of steps with a limit on relative change.

    From one gains row (g,) to another no step changes any gain by more than that share of itself.
    """
    low, high = STEP_SHARES
    if not low <= share <= high:
        raise InputError(f"given {share:g}; a step changes gains by {low:g} to {high:g} of themselves", key="--step")
    steps = steps_of_factor(present, tuned, 1.0 + share)
    if steps > MAX_STEPS_OPTION:
        raise InputError(
            f"given {share:g}, which takes {steps} steps; allowed are {MAX_STEPS_OPTION}: give a larger step",
            key="--step",
        )
    return steps


def steps_of_factor(present: Array, tuned: Array, most: float) -> int:
    """Return the number of steps with a limit on each factor.

    From one gains row (g,) to another; gains that change their sign do not count.
    """
    largest = float(np.max(factors_between(present, tuned), axis=0, initial=1.0))
    return max(ceil(log(largest) / log(most) - ROUNDING), 1)


def factors_between(before: Array, after: Array) -> Array:
    """Return the factors (g,), 1 or more, between two gains rows; 1 for gains that change their sign or are 0."""
    has_both = before * after > 0.0
    ratio = np.where(has_both, after, 1.0) / np.where(has_both, before, 1.0)
    return np.maximum(ratio, 1.0 / ratio)


def rows_between(present: Array, tuned: Array, steps: int) -> Array:
    """Return the gains rows (steps + 1, g) between two, both exact ends included."""
    share = np.linspace(0.0, 1.0, steps + 1)[:, None]
    has_both = present * tuned > 0.0
    ratio = np.where(has_both, tuned, 1.0) / np.where(has_both, present, 1.0)
    rows = np.where(has_both, present * ratio**share, present + share * (tuned - present))
    rows[0], rows[-1] = present, tuned
    return rows


def falls_short(step: Subject, present: Subject, tuned: Subject) -> list[LimitRow]:
    """Return the insufficient margins of a step, each with its allowed value."""
    rows = []
    for channel in step.looped:
        for limit in LIMITS:
            quantity = QUANTITIES[limit.quantity]
            ends = [float(quantity.to_limit(end.value(quantity, channel))) for end in (present, tuned)]
            value, label = step.value(quantity, channel), f"{quantity.name}({channel})"
            rows.append(limited_row(label, quantity, value, _allowed(limit, ends), True, channel))
    return [row for row in rows if not row.is_satisfied]


def _allowed(limit: LoopLimit, ends: list[float]) -> LoopLimit:
    """Return a limit that both ends keep, with room for rounding; an infinite end asks for no more than the limit."""
    finite = [end for end in ends if isfinite(end)]
    if limit.sense == "min":
        worst = min(limit.limit, *finite, limit.limit)
        return LoopLimit(limit.quantity, limit.sense, worst - ROUNDING * abs(worst))
    worst = max(limit.limit, *finite, limit.limit)
    return LoopLimit(limit.quantity, limit.sense, worst + ROUNDING * abs(worst))
