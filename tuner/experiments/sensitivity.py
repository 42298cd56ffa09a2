"""The sensitivity of a study: its own objectives, on its own search scenarios, the same ones for every sample."""

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from objectives.problem import Problem
from objectives.requirements import worth_flying
from plant.errors import InputError
from plant.scenarios import SEARCH
from tuner.analysis.sensitivity.analysis import Analysis, Sampled, analyse
from tuner.experiments.tuning.conclusion import batches
from tuner.experiments.tuning.run import problem_of
from tuner.study.study import Study


@dataclass(frozen=True)
class Budget:
    """What an analysis takes: candidates, flights and seconds, the last extrapolated from the flights of a few candidates."""

    candidates: int
    flights: int
    seconds: float


def study_problem(study: Study, threads: int | None) -> Problem:
    """Return the problem of a study; InputError where it searches nothing."""
    if not study.space.variables:
        raise InputError(
            'no gain is searched; give at least one a range, for instance "attitude.lambda" = {}',
            file=study.path, key="gains",
        )  # fmt: skip
    return problem_of(study, threads, None)


def budget(problem: Problem, study: Study, base: int) -> Budget:
    """Fly a few candidates, one a thread, and say what `base` samples take."""
    flown, threads = batches(study, SEARCH), problem.flyer.threads
    few = np.tile(study.default_row, (threads, 1))
    # Once for models and scenarios that are built when they are first needed.
    problem.evaluate_gains(few, flown, fly_all=True)
    begin = perf_counter()
    problem.evaluate_gains(few, flown, fly_all=True)
    each = (perf_counter() - begin) / threads
    candidates = base * (len(study.space.variables) + 2)
    return Budget(candidates, candidates * sum(batch.count for batch in flown), candidates * each)


def study_sensitivity(
    problem: Problem, study: Study, base: int, on_flights_done: Callable[[int], None] | None = None
) -> Analysis:
    """Analyse a study with `base` samples; on_flights_done(n) is called as n more flights end."""
    flown = batches(study, SEARCH)

    def evaluate(points: np.ndarray) -> Sampled:
        # All of the box is flown, also what a search would spare itself: the indices need independent inputs.
        found = problem.evaluate(points, flown, on_flights_done, fly_all=True)
        scores = tuple(found.samples(i, objective.scenario) for i, objective in enumerate(study.objectives))
        kept = worth_flying(study.requirements, found.requirements)
        return Sampled(found.values, found.failures, kept, scores)

    return analyse(base, len(study.space.variables), evaluate, study.seed)
