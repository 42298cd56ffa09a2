"""Findings of an inference: every setting flown, the inferred one and the ranges that reproduce the cells."""

from dataclasses import dataclass
from time import perf_counter

import numpy as np

from plant.quadrotor.scenarios import HELD_OUT
from plant.ties import first_smallest
from tuner.experiments.inference.flying import SettingFlyer
from tuner.experiments.inference.misfit import LOCAL_REFINEMENT, EvaluatedSettings, best_row, evaluate_settings, front
from tuner.experiments.inference.ranges import Range, ranges
from tuner.experiments.inference.refine import Jacobian
from tuner.search.front import evenly
from tuner.search.loop import Generation
from tuner.search.watcher import CHECKING, Watcher
from tuner.study.inference import Inference

# Settings of the front that are flown again at most; a longer one is thinned evenly along its first misfit.
MOST_CHECKED = 12


@dataclass(frozen=True)
class Findings:
    """The findings of an inference.

    Attributes:
        settings: All settings flown; row 0 is the default.
        chosen: Row of the inferred one.
        most: Row of the one with the most cells inside.
        shown: Rows of the front that were checked.
        checked: Held-out flights of the default, the chosen, the one with the most, and the shown, in this order.
        default_scores: Scores (cells, flights) of the default's held-out flights.
        scores: Scores (cells, flights) of the chosen one's held-out flights.
    """

    inference: Inference
    generations: list[Generation]
    settings: EvaluatedSettings
    chosen: int
    most: int
    shown: np.ndarray
    checked: EvaluatedSettings
    default_scores: np.ndarray
    scores: np.ndarray
    ranges: list[Range]
    flights: int
    seconds: float


def checked_findings(
    flyer: SettingFlyer,
    inference: Inference,
    generations: list[Generation],
    settings: EvaluatedSettings,
    jacobian: Jacobian,
    watcher: Watcher,
    begin: float,
) -> Findings:
    """Fly the inferred setting, the default and the front on held-out flights."""
    values = settings.misfits(inference)
    chosen, most, shown = best_row(values), most_inside(inference, settings), select_subset(values, front(values))
    rows = np.array([0, chosen, most, *shown])
    watcher.on_stage(CHECKING, len(rows) * flyer.flights_of(inference.held_out))
    scores, failed = flyer.fly(settings.values[rows], HELD_OUT, inference.held_out, watcher.on_flights_done)
    checked = evaluate_settings(inference, settings.values[rows], LOCAL_REFINEMENT, scores, failed)
    posterior = ranges(inference, settings, chosen, jacobian, scores[1])
    flown = len(settings.values) * flyer.flights_of(inference.flights)
    flights = flown + len(rows) * flyer.flights_of(inference.held_out)
    return Findings(
        inference,
        generations,
        settings,
        chosen,
        most,
        shown,
        checked,
        scores[0],
        scores[1],
        posterior,
        flights,
        perf_counter() - begin,
    )


def most_inside(inference: Inference, settings: EvaluatedSettings) -> int:
    """Return the setting with the most published cells inside; of equals the one of least misfit."""
    counts = settings.inside.sum(axis=1)
    best = np.flatnonzero(counts == counts.max(axis=0))
    return int(best[first_smallest(settings.overall(inference)[best])])


def select_subset(values: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return at most MOST_CHECKED rows of misfits (n, kinds): in the order of the first."""
    return rows[evenly(values[rows, 0], MOST_CHECKED)]
