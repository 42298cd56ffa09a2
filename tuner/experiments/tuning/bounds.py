"""Gains that ended at an end of their range: there the range was decided by its author and not by the search."""

from functools import singledispatch
from typing import Literal

import numpy as np

from plant.gains import MOST_OBSERVER
from tuner.documents.contest_document import BoundRow
from tuner.study.study import SearchedStudy, TuningStudy

# A gain within this share of its range, on the range's own scale, from an end counts as on it.
NEAR = 0.01
ENDS: tuple[Literal["low", "high"], ...] = ("low", "high")


def on_bounds(study: SearchedStudy, recommended: np.ndarray, front: np.ndarray) -> list[BoundRow]:
    """Return every variable that the recommended gains row (gains,) or a row of the front (n, gains) has near an end."""
    point = study.space.point(recommended)
    points = np.array([study.space.point(row) for row in front]).reshape(len(front), len(point))
    found = []
    for i, variable in enumerate(study.space.variables):
        for end, bound in zip(ENDS, (variable.low, variable.high), strict=True):
            here, near = (u <= NEAR if end == "low" else u >= 1.0 - NEAR for u in (point[i], points[:, i]))
            share = float(near.mean(axis=0)) if len(near) else 0.0
            if here or share > 0.0:
                value = float(recommended[study.space.columns[i][0]])
                row = BoundRow(
                    variable=variable.name, end=end, bound=bound, value=value, recommended=bool(here), share=share,
                    natural=natural_end(study, i, bound),
                )  # fmt: skip
                found.append(row)
    return found


@singledispatch
def natural_end(study: SearchedStudy, variable: int, bound: float) -> bool:  # noqa: ARG001
    """Return whether an end of the range of a variable cannot be moved.

    The gain is meaningless beyond it, or the observer would outrun the control period.
    """
    return False


@natural_end.register
def _(study: TuningStudy, variable: int, bound: float) -> bool:
    known = study.system.gains[study.space.columns[variable][0]].info
    period = study.system.timing.control_period
    return bound <= known.least or (known.observer and bound * period >= MOST_OBSERVER * (1.0 - 1e-9))
