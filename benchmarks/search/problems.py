"""The problems of the race: a study each, posed alike to every contestant of a seed."""

from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from objectives.problem import Problem
from plant.quadrotor.scenarios import HELD_OUT
from plant.seeds import generator
from tuner.experiments.tuning.problem import batches, problem_of
from tuner.experiments.tuning.starts import starting_points
from tuner.search.front import feasible_front, hypervolume, select_subset
from tuner.search.initial_design import initial_design
from tuner.study import Study, load_study

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent
# Control period and plant step are one: that changes metrics by 1e-7 and halves the time of a flight.
OVERRIDES = {"controller.plant_step": 0.004, "search.starts": []}
# Candidates of the common start, of which a contestant takes as many as its first batch has.
START = 64
# Held-out flights of a candidate, and candidates that fly them by the number of objectives: the best of one, else as many of the
# front as keep 98 to 100 % of the hypervolume of all fronts together. With three objectives 16 would keep 93 to 96 %.
FLIGHTS, FINALISTS = 64, {1: 8, 2: 16, 3: 48}
# Share of a limit by which held-out flights may exceed it: at the optimum a limit is met exactly, on other flights by chance.
SLACK = 0.02


class Posed(NamedTuple):
    """A problem: the study that poses it, and what it is in a few words."""

    study: Path
    about: str


PROBLEMS = {
    "quickstart": Posed(ROOT / "studies/quickstart.toml", "2 objectives, 7 gains, flights of 8 s"),
    "three": Posed(HERE / "studies/three.toml", "3 objectives, 8 gains, flights of 5 s"),
    "axes": Posed(HERE / "studies/axes.toml", "1 objective, travel limited, 18 gains, flights of 5 s"),
    "figure eight": Posed(ROOT / "studies/figure_eight.toml", "2 objectives, 7 gains, flights of 16 s"),
}


class Course:
    """A problem with a seed: where all contestants start, and the held-out flights by which they are judged."""

    def __init__(self, name: str, seed: int) -> None:
        self.name, self.seed = name, seed
        self._study = self.study({})
        held_out = tuple(replace(entry, held_out=FLIGHTS) for entry in self._study.scenarios)
        self._batches = batches(replace(self._study, scenarios=held_out), HELD_OUT)
        self._problem = self.problem(self._study)
        self._known: dict[bytes, tuple[np.ndarray, bool]] = {}
        self.objectives = len(self._study.objectives)
        self.default = self._flown(self._study.space.point(self._study.default_row)[None])[0][0]

    def study(self, overrides: dict[str, Any]) -> Study:
        """Return the study with values of its file replaced."""
        return load_study(PROBLEMS[self.name].study, {**OVERRIDES, "seed": self.seed, **overrides})

    def problem(self, study: Study) -> Problem:
        """Return what a study of this course asks, compiled, on one thread."""
        posed = problem_of(study, 1, None)
        posed.warm_up(study.default_row, study.scenarios[0].spec)
        return posed

    @cached_property
    def start(self) -> np.ndarray:
        """The first candidates (START, d): the default, then points of a Latin hypercube that keep what is known."""
        draw = generator(self.seed, "search/initial", 0)
        worthy = self._problem.worth_flying if self._study.requirements else None
        return initial_design(starting_points(self._study)[0][:1], START, draw, worthy)

    def front(self, points: np.ndarray) -> np.ndarray:
        """Return the values (k, m) on held-out flights of points (n, d), of those that keep the limits and that none beats."""
        values, kept = self._flown(points)
        return values[feasible_front(values, np.where(kept, 0.0, 1.0)[:, None])]

    def worth(self, front: np.ndarray) -> float | None:
        """Return the share of the box up to 1.1 times the default that a front (k, m) dominates.

        With one objective its least value, None where nothing kept the limits.
        """
        if self.objectives > 1:
            return hypervolume(front, self.default)
        return float(front.min()) if len(front) else None

    def _flown(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return values (n, m) of points (n, d), and which keep the limits (n,); each flies once."""
        new = np.array([point for point in points if point.tobytes() not in self._known])
        if len(new):
            found = self._problem.evaluate(new, self._batches, fly_all=True)
            allowed = np.zeros(found.violations.shape[1])
            allowed[: len(self._study.constraints)] = [SLACK * entry.most for entry in self._study.constraints]
            kept = np.all(found.violations <= allowed, axis=1)
            self._known |= {
                point.tobytes(): (values, bool(keeps))
                for point, values, keeps in zip(new, found.values, kept, strict=True)
            }
        rows = [self._known[point.tobytes()] for point in points]
        return np.array([row[0] for row in rows]).reshape(-1, self.objectives), np.array(
            [row[1] for row in rows], dtype=bool
        )


def finalists(points: np.ndarray, values: np.ndarray, violations: np.ndarray) -> np.ndarray:
    """Return the candidates (k, d) that fly held-out scenarios: those that add most to the front, or the best of one objective.

    points (n, d), values (n, m), violations (n, c): of all candidates.
    """
    if values.shape[1] == 1:
        feasible = np.flatnonzero(np.all(violations <= 0.0, axis=1))
        return points[feasible[np.argsort(values[feasible, 0], kind="stable")[: FINALISTS[1]]]]
    front = feasible_front(values, violations)
    return points[front[select_subset(values[front], values[0], FINALISTS[values.shape[1]], ends=False)]]
