"""The recommended point of a run's held-out flights: better gains, a point of the front, or the default as it is.

A default is what an engineer has. If points are better than it in every objective, by a relevant share in one, only they are
eligible; where none is and the default keeps the limits, it stays. One that breaks a limit makes way for a point that loses less
than a relevant share in an objective, too, and then for those that hardly lose more than the front must. A default that is among
the worst of a first generation in some objectives, and breaks a limit or is far behind the front, is good in the others because
of that: the pick rule then has the whole front, unless a point that is better in everything halves what the default is worst in.
So a point with large losses moves no pick, unless the whole front is eligible.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from objectives.evaluator import Evaluation
from objectives.risk import RELEVANT
from plant.ties import first_smallest
from tuner.search.front import PICKS, non_dominated, pick
from tuner.study.searched import SearchedStudy
from tuner.text.numbers import significant

FAR = 0.8
"""Geometric mean of the objectives in those of the default up to which a point that is no worse in any is far ahead of it."""
WORST = 0.9
"""Share of the candidates that are no worse than the default in an objective from which on it is among the worst in it."""
HALVED = 0.5
"""Ratio to the default in each objective in which it is among the worst up to which a point mends it: a motor's whole front has
0.15 or less of the default's travel, and a satellite that never settles has 0.8 of its time for less effort."""
SMALL_LOSS = 0.2
"""Share of the default's value by which a point may lose more in an objective than the front's smallest loss and is eligible."""
MAX_VALUE = 1e300
"""Largest value in comparisons with the default: an infinite value counts as this."""
EVERYWHERE = "better on held-out flights than the default in every objective"


class Choice(NamedTuple):
    """Row of the recommended finalist, 0 for the default; and the reason."""

    row: int
    why: str


class Default(NamedTuple):
    """A default as the one to compare with.

    Args:
        keeps: Whether it keeps every limit.
        worst: Mask (m,) of the objectives in which it is among the worst tried.
        relevant: Share of its values from which a difference matters.
    """

    keeps: bool
    worst: np.ndarray
    relevant: float = RELEVANT

    @property
    def why_kept(self) -> str:
        """The reason for keeping it."""
        return f"no finalist is better in every objective, by {100.0 * self.relevant:g} % in one"


def worst_objectives(first: Evaluation) -> np.ndarray:
    """Return the mask (m,) of a default's worst objectives.

    The default is the first candidate of a first generation, and among the worst in them.
    Later generations crowd where the search looks, so they say nothing about what is usual.
    """
    flown = first.values[first.flown]
    if len(flown) < 2:
        return np.zeros(first.values.shape[1], dtype=bool)
    return first.values[0] >= np.quantile(flown, WORST, axis=0, method="higher")


def recommend(study: SearchedStudy, values: np.ndarray, default: Default, front: np.ndarray) -> Choice:
    """Return the choice among the default and a front.

    Args:
        study: Its pick rule and objectives.
        values: Held-out objectives (rows, m), the default first.
        default: Further data of the point.
        front: Rows (k,) of the non-dominated finalists that keep every limit, one at least.
    """
    labels = [objective.label for objective in study.objectives]
    among, which = alternatives(values, default, front, study.pick in PICKS)
    if not len(among):
        return Choice(0, default.why_kept)
    if len(labels) == 1:
        return Choice(
            int(among[first_smallest(values[among, 0])]), f"smallest {labels[0]} of the finalists within limits"
        )
    chosen, why = pick(study.pick, values[among], labels)
    only = "the only point that is " if len(among) == 1 and which else f"{why}, among points " if which else why
    return Choice(int(among[chosen]), f"{only}{which}")


def alternatives(
    values: np.ndarray, default: Default, front: np.ndarray, weighs_all: bool = True
) -> tuple[np.ndarray, str]:
    """Return the eligible rows of a front, with words on them.

    There are none where the default is as good.

    weighs_all: whether the pick rule weighs the objectives itself, and names none of them.
    """
    # Shares of an infinite value, of a default that is lost in most flights, are no numbers.
    values = np.minimum(values, MAX_VALUE)
    better = front[is_improvement(values[front], values[0], default.relevant)]
    everywhere = better[np.all(values[better] < values[0], axis=1)]
    # One that is among the worst in everything is good in nothing because of that.
    is_lopsided = bool(np.any(default.worst)) and not np.all(default.worst)
    is_poor = is_lopsided and (not default.keeps or is_far_behind(values[0], values[front]))
    if is_poor and not is_mended(values[everywhere], values[0], default.worst):
        return front, ""
    if len(everywhere):
        return everywhere, EVERYWHERE
    if default.keeps:
        # With `better` 12 of 24 runs from tuned gains ended a step along the front, of up to 1.8 % in one objective.
        return (everywhere if weighs_all else front), ""
    if len(better):
        return (
            better,
            f"better than the default by {100.0 * default.relevant:g} % in an objective, without losing as much in another",
        )
    return with_small_losses(values, front) if weighs_all else (front, "")


def is_improvement(values: np.ndarray, default: np.ndarray, relevant: float = RELEVANT) -> np.ndarray:
    """Return the mask (n,) of values (n, m) better than a default (m,).

    They are better by a relevant share in an objective and not worse by as much in another.
    """
    step = relevant * np.abs(default)
    return np.any(values < default - step, axis=1) & np.all(values <= default + step, axis=1)


def with_small_losses(values: np.ndarray, front: np.ndarray) -> tuple[np.ndarray, str]:
    """Return the rows of a front (k,) with small losses, and words.

    A loss is relative to the default's value, or to the front's largest if that is 0; the largest of a row counts. The knee of a
    greenhouse's front had twice the error of a default whose overshoot was 18 % where 15 % are allowed. The smallest loss alone
    is blind to gains of other points.
    """
    scale = np.where(values[0] == 0.0, np.abs(values[front]).max(axis=0), np.abs(values[0]))
    scale[scale == 0.0] = 1.0
    losses = np.max((values[front] - values[0]) / scale, axis=1)
    most = max(losses.min(), 0.0) + SMALL_LOSS
    words = f"at most {significant(100.0 * most, 2)} % worse in an objective than the default, which breaks a limit"
    return front[losses <= most], words


def is_mended(values: np.ndarray, default: np.ndarray, worst: np.ndarray) -> bool:
    """Return True if one of the values (n, m) halves all the worst.

    default (m,), worst (m,): see `Default`.
    """
    return bool(np.any(np.all(values <= default - (1.0 - HALVED) * np.abs(default), axis=1, where=worst)))


def is_far_behind(default: np.ndarray, front: np.ndarray) -> bool:
    """Return True for a default (m,) far behind a point of a front (k, m).

    That point is not worse in any objective.
    """
    ahead = front[np.all(front <= default, axis=1)]
    if not len(ahead) or np.any(default <= 0.0):
        return False
    return bool(np.any(np.prod(np.maximum(ahead, 0.0) / default, axis=1) <= FAR ** len(default)))


def best_row(study: SearchedStudy, worst: np.ndarray, values: np.ndarray, feasible: np.ndarray) -> int:
    """Return the row to recommend, 0 for the default or none.

    worst: see `Default`; values (rows, m), feasible (rows,): the default first.
    """
    rows = 1 + np.flatnonzero(feasible[1:])
    if not len(rows):
        return 0
    return recommend(
        study, values, Default(bool(feasible[0]), worst, study.table.relevant), rows[non_dominated(values[rows])]
    ).row


def choose_finalist(
    study: SearchedStudy,
    values: np.ndarray,
    default: Default,
    front: np.ndarray,
    excess: np.ndarray,
    names: Sequence[str],
) -> Choice:
    """Return the choice of finalists: a point, the default, or the nearest where nothing keeps every limit.

    front: may be empty; excess (rows, limits), names: of the rows; else as `recommend`.
    The excess is relative to each limit: those in metres and in percent are added.
    """
    if not len(front) and default.keeps:
        return Choice(0, "no finalist satisfies every limit on the held-out scenarios, and the default does")
    if not len(front):
        nearest = first_smallest(excess[1:].sum(axis=1)) + 1
        why = "no finalist satisfies every constraint on the held-out scenarios; this one violates them least"
        return Choice(nearest, why)
    row, why = recommend(study, values, default, front)
    among, _ = alternatives(values, default, front)
    pair = among if len(among) == 2 else front
    if row and len(pair) == 2:
        (other,) = pair[pair != row].tolist()
        why = f"{why}; the other point is {names[other]}"
    return Choice(row, why)
