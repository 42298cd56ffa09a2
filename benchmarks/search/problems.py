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
from tuner.study.kinds import load_gains_study
from tuner.study.study import TuningStudy

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent
# Control period and plant step are one: that changes metrics by 1e-7 and halves the time of a flight. All begin from the course's
# start, and not from the front that comes with the tool.
OF_QUADROTORS = {"controller.plant_step": 0.004, "search.starts": []}
# Candidates of the common start, of which a contestant takes as many as its first batch has.
START = 64
# Held-out flights of a candidate, and candidates that fly them by the number of objectives: the best of one, else as many of the
# front as keep 98 to 100 % of the hypervolume of all fronts together. With three objectives 16 would keep 93 to 96 %.
FLIGHTS, FINALISTS = 64, {1: 8, 2: 16, 3: 48}
# Share of a limit by which held-out flights may exceed it: at the optimum a limit is met exactly, on other flights by chance.
SLACK = 0.02


class Posed(NamedTuple):
    """A problem: the study that poses it, and what it is in a few words.

    overrides: of the study. judge_seed: seed of the held-out flights; None for that of the search, so that the best known is one
    of a seed.
    """

    study: Path
    about: str
    overrides: dict[str, Any] = OF_QUADROTORS
    judge_seed: int | None = None


def posed_for_validation(name: str, about: str, overrides: dict[str, Any] = OF_QUADROTORS) -> Posed:
    """Return a problem whose runs are all judged on the same flights."""
    return Posed(HERE / f"studies/{name}.toml", about, overrides, judge_seed=4242)


RACED = {
    "quickstart": Posed(ROOT / "studies/quickstart.toml", "2 objectives, 7 gains, flights of 8 s"),
    "three": Posed(HERE / "studies/three.toml", "3 objectives, 8 gains, flights of 5 s"),
    "axes": Posed(HERE / "studies/axes.toml", "1 objective, travel limited, 18 gains, flights of 5 s"),
    "figure eight": Posed(ROOT / "studies/figure_eight.toml", "2 objectives, 7 gains, flights of 16 s"),
}
VALIDATION = {
    "iris in a gust": posed_for_validation(
        "hummingbird_gust",
        "3 objectives, 7 gains, a gust of 12 m/s, the default breaks margins",
        {**OF_QUADROTORS, "airframe.name": "iris", "scenario.0.air.gust.amplitude": 12.0},
    ),
    "hummingbird in a gust": posed_for_validation("hummingbird_gust", "3 objectives, 7 gains, a gust of 10 m/s"),
    "pid12": posed_for_validation("pid12", "2 objectives, 12 gains of PID, flights of 8 s"),
    "pid15": posed_for_validation("pid15", "2 objectives, 15 gains of PID, flights of 8 s"),
    "helicopter": posed_for_validation("helicopter", "a plant of two channels side by side, 3 objectives, 6 gains", {}),
    "shaft": posed_for_validation("shaft", "a plant of two channels in a cascade, 2 objectives, 6 gains", {}),
}
"""Problems on which no search was developed."""
PROBLEMS = RACED | VALIDATION


class Course:
    """A problem with a seed: where all contestants start, and the held-out flights by which they are judged."""

    def __init__(self, name: str, seed: int) -> None:
        self.name, self.seed, self._posed = name, seed, PROBLEMS[name]
        self._study = self.study({})
        judge = self.study({} if self._posed.judge_seed is None else {"seed": self._posed.judge_seed})
        held_out = tuple(replace(entry, held_out=FLIGHTS) for entry in judge.scenarios)
        self._batches = batches(replace(judge, scenarios=held_out), HELD_OUT)
        self._problem, self._judge = self.problem(self._study), self.problem(judge)
        self._known: dict[bytes, tuple[np.ndarray, bool]] = {}
        self.objectives = len(self._study.objectives)
        self.default = self._flown(self._study.space.point(self._study.default_row)[None])[0][0]

    def study(self, overrides: dict[str, Any]) -> TuningStudy:
        """Return the study with values of its file replaced."""
        changes = {**self._posed.overrides, "seed": self.seed, **overrides}
        return load_gains_study(self._posed.study, "benchmarks.search", changes)

    def problem(self, study: TuningStudy) -> Problem:
        """Return what a study of this course asks, compiled, on one thread."""
        posed = problem_of(study, 1, None)
        posed.warm_up(study.default_row, study.scenarios[0].spec)
        return posed

    @cached_property
    def start(self) -> np.ndarray:
        """The first candidates (START, d): the default, then points of a Latin hypercube that keep what is known."""
        draw = generator(self.seed, "search/initial", 0)
        excess = self._problem.excess if self._study.requirements else None
        return initial_design(starting_points(self._study)[0][:1], START, draw, excess)

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
            found = self._judge.evaluate(new, self._batches, fly_all=True)
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
