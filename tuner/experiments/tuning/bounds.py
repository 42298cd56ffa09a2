"""Gains that ended at an end of their range: there the range was decided by its author and not by the search."""

from typing import Literal

import numpy as np

from tuner.documents.comparison_document import BoundRow
from tuner.study.searched import SearchedStudy

# A gain within this share of its range, on the range's own scale, from an end counts as on it.
NEAR = 0.01
ENDS: tuple[Literal["low", "high"], ...] = ("low", "high")


def on_bounds(study: SearchedStudy, recommended: np.ndarray, front: np.ndarray) -> list[BoundRow]:
    """Return the variables that `recommended` (gains,) or `front` (n, gains) has near an end."""
    point = study.space.point(recommended)
    points = np.array([study.space.point(row) for row in front]).reshape(len(front), len(point))
    rows = []
    for i, variable in enumerate(study.space.variables):
        for end, bound in zip(ENDS, (variable.low, variable.high), strict=True):
            is_near, near = (u <= NEAR if end == "low" else u >= 1.0 - NEAR for u in (point[i], points[:, i]))
            share = float(near.mean(axis=0)) if len(near) else 0.0
            if is_near or share > 0.0:
                value = float(recommended[study.space.columns[i][0]])
                row = BoundRow(
                    variable=variable.name,
                    end=end,
                    bound=bound,
                    value=value,
                    recommended=bool(is_near),
                    share=share,
                    natural=study.is_natural_end(i, bound),
                )
                rows.append(row)
    return rows
