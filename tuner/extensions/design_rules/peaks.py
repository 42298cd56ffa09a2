"""Peaks of a channel's sampled loop under designed gains."""

import numpy as np

from objectives.design.plant_design import ChannelDesign
from objectives.margins.plant_margins import PlantMargins
from tuner.study.plant_study import PlantStudy

Array = np.ndarray


def judged(study: PlantStudy, row: Array, name: str) -> ChannelDesign:
    """Return the peaks of a channel's sampled loop."""
    margins = PlantMargins(study.system, 0.9 * row, 1.1 * row).evaluate(row[None])
    i = study.system.plan.names.index(name)
    ms, mt = (float(getattr(margins, field).value[0, i]) for field in ("sensitivity", "complementary"))
    why = "" if np.isfinite(ms) else "the loop that the rule gives is not stable"
    return ChannelDesign(np.isfinite(ms).item(), why, ms, mt)
