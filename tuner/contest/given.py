"""The front of a contender whose gains are given: its one point, where it keeps every constraint."""

import numpy as np

from tuner.contest.comparison import Comparison
from tuner.contest.contest import Contest
from tuner.contest.flying import Flown
from tuner.contest.fronts import Front
from tuner.contest.tuning import GIVEN


def given_front(contest: Contest, contender: int, flown: Flown, comparison: Comparison) -> Front:
    """Return a front of one point, or of none where a constraint is broken."""
    estimates = comparison.estimates[contender]
    kept = all(
        quantity.limit is None or estimates[i].value <= quantity.limit for i, quantity in enumerate(contest.quantities)
    )
    count = len(contest.base.objectives)
    rows = slice(0, int(kept))
    ends = np.array([[e.value, e.low, e.high] for e in estimates[:count]])
    return Front(
        points=[GIVEN][rows],
        candidates=np.array([-1])[rows],
        gains=contest.contenders[contender].study.default_row[None][rows],
        values=ends[None, :, 0][rows],
        low=ends[None, :, 1][rows],
        high=ends[None, :, 2][rows],
        samples=[
            flown.samples(i, objective.scenario)[[contender]][rows]
            for i, objective in enumerate(contest.base.objectives)
        ],
    )
