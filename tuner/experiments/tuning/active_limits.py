"""Finalists on both sides of a limit that binds.

A search keeps a limit by the value of few flights, the held-out check by the end of an interval over many. All candidates of a
search share their flights, so their errors are nearly one: where the front of the search stands at a limit, all of it may lie
beyond, or all of it too far inside. So its excess over the limits, in halves of its own interval, counts as one objective more:
who is better for being a little outside is a finalist too, and so is who is a little worse and safely inside.
"""

from typing import NamedTuple

import numpy as np

from objectives.evaluator import Constraint, Evaluation
from plant.seeds import generator
from plant.ties import increasing_order
from tuner.analysis.final_flights import FRONT_REPLICATES
from tuner.search.front import non_dominated, select_subset

CONFIDENCE = 0.95
"""Confidence of the intervals of a search's values if a study names none: its few flights err all the same."""
DEEPEST = 2.0
"""Half-widths inside a limit up to which being further inside counts: flights of other streams err alike about neighbors."""


class BackOff(NamedTuple):
    """Distances inside limits, NaN where none was measured.

    Attributes:
        shift: Distances (limits,) from the search's value to the upper end of the interval of as many flights as are held out.
        width: Half-widths (limits,) of that interval.
    """

    shift: np.ndarray
    width: np.ndarray


def shifted_excess(evaluation: Evaluation, back_off: BackOff | None) -> np.ndarray:
    """Return the excess (n, limits and requirements) behind a back-off."""
    excess = evaluation.excess.copy()
    if back_off is not None:
        excess[:, : len(back_off.shift)] += np.nan_to_num(back_off.shift)
    return excess


def standard_excess(
    evaluation: Evaluation, constraints: tuple[Constraint, ...], root: int, back_off: BackOff | None = None
) -> np.ndarray:
    """Return the largest excess (n,) over a limit, in half-widths of intervals.

    -1 and below: the whole interval is within every limit; above 1: beyond one. Limits on known values, on shares and on worst
    cases, and automatic ones, have no tolerance: infinite where they are broken. Behind a back-off the whole interval
    is within at 0.
    """
    excess = shifted_excess(evaluation, back_off)
    worst = np.where(np.any(excess[:, len(constraints) :] > 0.0, axis=1) | ~evaluation.flown, np.inf, -np.inf)
    for i in range(len(constraints)):
        if back_off is not None and not np.isnan(back_off.width[i]):
            below = above = np.full(len(excess), back_off.width[i])
        else:
            below, above = widths(evaluation, constraints, i, root)
        width, certain = np.where(excess[:, i] > 0.0, below, above), np.where(excess[:, i] > 0.0, np.inf, -np.inf)
        # Of an interval that is all but a point the quotient is infinite, as of a certain value.
        with np.errstate(over="ignore"):
            quotient = excess[:, i] / np.where(width > 0.0, width, 1.0)
        worst = np.maximum(worst, np.where(width > 0.0, quotient, certain))
    return worst


def widths(
    evaluation: Evaluation,
    constraints: tuple[Constraint, ...],
    i: int,
    root: int,
    rows: np.ndarray | slice = slice(None),
) -> tuple[np.ndarray, np.ndarray]:
    """Return the distances (n,) from a constraint's values to their intervals' ends.

    Both, down and up, are 0 without tolerance. rows (n,): of the evaluation.
    """
    entry, value = constraints[i], constraints[i].most + evaluation.excess[rows, i]
    if not entry.has_tolerance:
        return np.zeros(len(value)), np.zeros(len(value))
    samples = evaluation.samples(evaluation.scores.shape[1] - len(constraints) + i, entry.objective.scenario)[rows]
    count = samples.shape[-1]
    drawn = generator(root, "bootstrap/limit", i).integers(count, size=(FRONT_REPLICATES, count), dtype=np.intp)
    low, high = entry.objective.interval(samples, drawn, entry.confidence or CONFIDENCE)
    return value - low, high - value


def beside_limits(
    evaluation: Evaluation,
    constraints: tuple[Constraint, ...],
    chosen: np.ndarray,
    root: int,
    most: int,
    back_off: BackOff | None = None,
) -> np.ndarray:
    """Return rows (k,) around the limits that bind.

    Of one objective the next best follow.

    Args:
        evaluation: Evaluation of all candidates.
        constraints: Limits on flights.
        chosen: Rows of finalists, which are not returned.
        root: Root seed.
        most: Largest number of rows.
        back_off: Measured by fresh flights.
    """
    excess = standard_excess(evaluation, constraints, root, back_off)
    hopeful = np.flatnonzero((excess <= 1.0) & evaluation.complete)
    rows = np.array([], dtype=int)
    if np.any(excess[hopeful] > -1.0):
        sides = np.column_stack([evaluation.values[hopeful], np.clip(excess[hopeful], -DEEPEST, 1.0) + DEEPEST])
        front = hopeful[non_dominated(sides)]
        sides = sides[np.searchsorted(hopeful, front)]
        fresh = ~np.isin(front, chosen)
        front, sides = front[fresh], sides[fresh]
        rows = front[select_subset(sides, sides.max(axis=0), most, ends=False)] if len(front) else front
    if evaluation.values.shape[1] == 1 and len(rows) < most:
        left = hopeful[(excess[hopeful] <= 0.0) & ~np.isin(hopeful, [*chosen, *rows])]
        next_best = left[increasing_order(evaluation.values[left, 0])][: most - len(rows)]
        rows = np.concatenate([rows, next_best])
    return rows
