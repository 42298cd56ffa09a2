"""Peaks of the channels' sampled loops under designed gains."""

import numpy as np

from objectives.design.plant_design import ChannelDesign
from objectives.margins.plant_margins import PlantMargins
from tuner.study.plant_study import PlantStudy

Array = np.ndarray


def judged(study: PlantStudy, row: Array) -> dict[str, ChannelDesign]:
    """Return each channel's design with the peaks of its sampled loop."""
    margins = PlantMargins(study.system, 0.9 * row, 1.1 * row).evaluate(row[None])
    peaks = (getattr(margins, field).value[0].tolist() for field in ("sensitivity", "complementary"))
    designs = {}
    for name, ms, mt in zip(study.system.plan.names, *peaks, strict=True):
        why = "" if np.isfinite(ms) else "the loop that the rule gives is not stable"
        designs[name] = ChannelDesign(np.isfinite(ms).item(), why, ms, mt)
    return designs
