"""Gains that ended at an end of their range: there the range was decided by its author and not by the search."""

from dataclasses import dataclass

import numpy as np

from plant.gains import MOST_OBSERVER, gain_addresses
from tuner.study.study import Study

# A gain within this share of its range, on the range's own scale, from an end counts as on it.
NEAR = 0.01
ENDS = ("low", "high")


@dataclass(frozen=True)
class OnBound:
    """A variable near an end of its range. end: "low" or "high"; bound: that end; value: the recommended point's.

    recommended: whether that point is near the end; share: of the front's points that are. natural: the end cannot be
    moved, because the gain is meaningless beyond or the observer would outrun the control period.
    """

    variable: str
    end: str
    bound: float
    value: float
    recommended: bool
    share: float
    natural: bool


def on_bounds(study: Study, recommended: np.ndarray, front: np.ndarray) -> list[OnBound]:
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
                natural = natural_end(study, i, bound)
                found.append(OnBound(variable.name, end, bound, value, bool(here), share, natural))
    return found


def natural_end(study: Study, variable: int, bound: float) -> bool:
    """Return whether an end of the range of a variable cannot be moved, see `OnBound`."""
    known = gain_addresses(study.system.cascade)[study.space.columns[variable][0]].info
    period = study.system.timing.control_period
    return bound <= known.least or (known.observer and bound * period >= MOST_OBSERVER * (1.0 - 1e-9))
