"""Further finalists, chosen by flights of the first ones.

A search keeps a limit by few flights, which all candidates share. The finalists' held-out values lie above or below those of the
search, and the values of other candidates probably do by as much. With one objective a candidate that then keeps every limit and
is better than the recommended point becomes a finalist. If there is none, those between the last finalist that breaks a limit and
the recommended one fly that would keep it by the smallest of all distances: chosen candidates have too small values in a search.

With several objectives an end of the front may prove worse than the search found it, or break a limit; candidates behind it may
be better, or keep them. A satellite's quickest finalist settled in 24.5 s, by the search in 17.3 s, and one of four such
candidates in 17.7 s. Of six runs under four limits one lost its nine quietest finalists, and six candidates behind them raised
its share of what all six dominate from 74 to 95 %. If most of a front break a limit, candidates further inside fly: of those runs
the two with the fewest points kept 52 and 85 % of it, and 80 and 92 % with 16 such candidates.
"""

import numpy as np

from objectives.evaluator import Evaluation
from plant.ties import first_smallest, increasing_order
from tuner.experiments.tuning.active_limits import BackOff, standard_excess
from tuner.experiments.tuning.survivors import layers
from tuner.experiments.tuning.validation import Validated
from tuner.search.front import non_dominated, select_subset
from tuner.study.searched import SearchedStudy

MAX_ROUNDS = 3
"""Rounds of further finalists with one objective."""
MAX_FRONT_ROUNDS = 1
"""Rounds with several objectives."""
N_FURTHER_FINALISTS = 8
"""Further finalists of a round near one point."""
MIN_FURTHER_AT_ENDS = 3
"""Candidates behind the ends of a front from which on they fly: judging all again takes a tenth of a quickstart even for one."""
N_FURTHER_ON_FRONT = 16
"""Further finalists of a round near a front."""
N_NEAR_FINALISTS = 5
"""Finalists nearest to a limit: their held-out flights give the error of the search there."""


def further_finalists(
    seen: Evaluation, study: SearchedStudy, candidates: np.ndarray, validated: Validated
) -> np.ndarray:
    """Return archive indices (k,) of better candidates that probably keep all limits.

    Args:
        seen: All candidates of the search, on the flights that all of them made.
        study: Study with limits and the difference that matters.
        candidates: Archive indices of the finalists behind the default.
        validated: Their validation.
    """
    if seen.values.shape[1] > 1:
        return further_points_of_front(seen, study, candidates, validated)
    if not any(entry.has_tolerance for entry in study.constraints):
        return candidates[:0]
    value, best = seen.values[:, 0], np.inf
    if validated.keeps:
        best = value[[0, *candidates][validated.tuned]]
        best -= study.table.relevant * abs(best)
    is_better = (value < best) & seen.complete
    is_better[[0, *candidates]] = False
    searched, least = seen.excess[candidates], largest_broken(value[candidates], best, study, validated)
    further = candidates[:0]
    for is_mildest, above in ((False, -np.inf), (True, least)):
        if not len(further):
            back_off = shown_back_off(searched, study, validated, is_mildest)
            excess = standard_excess(seen, study.constraints, study.seed, back_off)
            rows = np.flatnonzero(is_better & (excess <= 0.0) & (value > above))
            further = thinned(rows, np.column_stack([value[rows], excess[rows]]))
    return further


def further_points_of_front(
    seen: Evaluation, study: SearchedStudy, candidates: np.ndarray, validated: Validated
) -> np.ndarray:
    """Return archive indices (k,) of candidates for a front's ends, or inside.

    If most finalists break a limit, the front further inside the limits flies. Else, for each end, candidates fly that are ahead,
    by the search, of the best finalist by held-out flights that keeps every limit. Arguments as those of `further_finalists`.
    """
    is_within = validated.finalists.feasible[1:]
    within = candidates[is_within]
    is_broken = 2 * len(within) < len(candidates)
    back_off = shown_back_off(seen.excess[candidates], study, validated) if is_broken else None
    excess = standard_excess(seen, study.constraints, study.seed, back_off)
    is_new = seen.complete & (excess <= 0.0)
    is_new[[0, *candidates]] = False
    if is_broken:
        rows = np.concatenate([within, np.flatnonzero(is_new)])
        inside = np.setdiff1d(rows[non_dominated(seen.values[rows])], within)
        values = seen.values[inside]
        return np.sort(inside[select_subset(values, values.max(axis=0, initial=0.0), N_FURTHER_ON_FRONT)])
    further, held_out = candidates[:0], validated.finalists.evaluation.values[1:][is_within]
    for value, flown in zip(seen.values.T, held_out.T, strict=True):
        best = value[within[first_smallest(flown)]]
        rows = np.flatnonzero(is_new & (value < best - study.table.relevant * abs(best)))
        further = np.union1d(further, thinned(rows, np.column_stack([value[rows], excess[rows]])))
    return further if len(further) >= MIN_FURTHER_AT_ENDS else candidates[:0]


def largest_broken(value: np.ndarray, best: float, study: SearchedStudy, validated: Validated) -> float:
    """Return the largest better value of a finalist that breaks limits.

    Between it and the recommended point lies the best that keeps all limits, if these cost.
    """
    limits = np.array([entry.most if entry.has_tolerance else np.inf for entry in study.constraints])
    is_broken = np.any(validated.finalists.limits[1, 1:] > limits, axis=1) & (value < best)
    return float(value[is_broken].max(initial=-np.inf))


def shown_back_off(
    searched: np.ndarray, study: SearchedStudy, validated: Validated, is_mildest: bool = False
) -> BackOff:
    """Return the distances from the search's values to those of held-out flights.

    Args:
        searched: Excess (finalists, limits and requirements) in the search.
        study: Study with limits.
        validated: Validation of the finalists.
        is_mildest: Whether the smallest distance of all finalists counts, not the median of those nearest to a limit.
    """
    value, low, high = validated.finalists.limits[:, 1:]
    shift, width = np.full((2, len(study.constraints)), np.nan)
    for i, entry in enumerate(study.constraints):
        if entry.has_tolerance:
            judged = value[:, i] - entry.most
            near = increasing_order(np.abs(judged))[:N_NEAR_FINALISTS]
            distances = judged - searched[:, i]
            shift[i] = distances.min() if is_mildest else np.median(distances[near])
            width[i] = max(np.median(high[near, i] - low[near, i]) / 2.0, np.finfo(float).tiny)
    return BackOff(shift, width)


def thinned(rows: np.ndarray, sides: np.ndarray) -> np.ndarray:
    """Return at most `N_FURTHER_FINALISTS` rows: those furthest inside the limits for their value, spread by it.

    sides (rows, 2): values and excess. All fly the same flights, so their order by excess is surer than the excess itself.
    """
    if len(rows) <= N_FURTHER_FINALISTS:
        return rows
    behind = layers(sides)
    last = int(np.searchsorted(np.cumsum(np.bincount(behind)), N_FURTHER_FINALISTS))
    inner, outer = np.flatnonzero(behind < last), np.flatnonzero(behind == last)
    outer = outer[increasing_order(sides[outer, 0])]
    spread = np.linspace(0, len(outer) - 1, N_FURTHER_FINALISTS - len(inner)).astype(int)
    return rows[np.concatenate([inner, outer[np.unique(spread)]])]
