"""The findings of an inference, whole: every setting flown, the inferred one and the ranges that reproduce the cells."""

from dataclasses import dataclass

import numpy as np

from tuner.experiments.inference.misfit import EvaluatedSettings
from tuner.experiments.inference.ranges import Range
from tuner.search.loop import Generation
from tuner.study.inference import Inference


@dataclass(frozen=True)
class Findings:
    """The findings of an inference.

    found: all settings flown; row 0 is the default. chosen: row of the inferred one; most: of the one with the most cells
    inside; shown: rows of the front that were checked. checked: the held-out flights of the default, of the chosen, of the
    one with the most, and of the shown, in this order. default_scores, scores (cells, flights): held-out flights of the
    default and of the chosen.
    """

    inference: Inference
    generations: list[Generation]
    found: EvaluatedSettings
    chosen: int
    most: int
    shown: np.ndarray
    checked: EvaluatedSettings
    default_scores: np.ndarray
    scores: np.ndarray
    ranges: list[Range]
    flights: int
    seconds: float
