"""Further finalists of one objective, chosen by flights of the first ones.

A search keeps a limit by few flights, which all candidates share. The finalists' held-out values lie above or below those of the
search, and the values of other candidates probably do by as much. A candidate that then keeps every limit and is better than the
recommended point becomes a finalist. In a study of settling (three seeds) the recommended objective was 22 % above the best known
with the first finalists alone, and is 15 % above it with further ones.
"""

import numpy as np

from objectives.evaluator import Evaluation
from plant.ties import increasing_order
from tuner.experiments.tuning.active_limits import BackOff, has_tolerance, standard_excess
from tuner.experiments.tuning.survivors import layers
from tuner.experiments.tuning.validation import Validated
from tuner.study.searched import SearchedStudy

MAX_ROUNDS = 3
"""Rounds of further finalists."""
N_FURTHER_FINALISTS = 8
"""Further finalists of a round."""
N_NEAR_FINALISTS = 5
"""Finalists nearest to a limit: their held-out flights give the error of the search there."""


def further_finalists(
    seen: Evaluation, study: SearchedStudy, candidates: np.ndarray, validated: Validated
) -> np.ndarray:
    """Return archive indices (k,) of better candidates that probably keep all limits; none with several objectives.

    Args:
        seen: All candidates of the search, on the flights that all of them made.
        study: Study with limits and the difference that matters.
        candidates: Archive indices of the finalists behind the default.
        validated: Their validation.
    """
    if seen.values.shape[1] > 1 or not any(map(has_tolerance, study.constraints)):
        return candidates[:0]
    value, best = seen.values[:, 0], np.inf
    if validated.keeps:
        best = value[[0, *candidates][validated.tuned]]
        best -= study.table.relevant * abs(best)
    excess = standard_excess(
        seen, study.constraints, study.seed, shown_back_off(seen.excess[candidates], study, validated)
    )
    is_better = (value < best) & (excess <= 0.0) & seen.complete
    is_better[[0, *candidates]] = False
    rows = np.flatnonzero(is_better)
    return thinned(rows, np.column_stack([value[rows], excess[rows]]))


def shown_back_off(searched: np.ndarray, study: SearchedStudy, validated: Validated) -> BackOff:
    """Return the distances from the search's values to those of held-out flights.

    They are those of the finalists nearest to each limit. searched: excess (finalists, limits and requirements) in the search.
    """
    value, low, high = validated.finalists.limits[:, 1:]
    shift, width = np.full((2, len(study.constraints)), np.nan)
    for i, entry in enumerate(study.constraints):
        if has_tolerance(entry):
            judged = value[:, i] - entry.most
            near = increasing_order(np.abs(judged))[:N_NEAR_FINALISTS]
            shift[i] = np.median(judged[near] - searched[near, i])
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
