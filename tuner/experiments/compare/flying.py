"""The flights of a comparison: every contender, and every point of its front, through the same scenarios.

Scenarios are drawn once, chunk by chunk, and every contender flies a chunk while it is there: so flight i of a scenario
is the same air, the same noise and the same relative spread of the vehicle for all of them, whatever their airframe.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from objectives.decisions import DecisionSpace
from objectives.problem import Problem, seen_scores
from plant.backends.flyer import FlightInputs
from plant.threads import available_threads
from tuner.study.comparison import ComparisonStudy, Contender
from tuner.study.study import StudyScenario

# Scenarios of one task; a flight of 25 s takes 0.6 MB of air, and three times that while it is laid out in lanes.
CHUNK = 64


@dataclass(frozen=True)
class ComparedPoint:
    """A contender at gains that fly.

    Attributes:
        point: Its name among the contender's points.
        row: Gains row (gains,).
        candidate: Index in the contender's search, -1 where it comes from none.
        picked: Values (objectives,) on other scenarios, which decide the pick; None where there are none to compare.
    """

    contender: Contender
    point: str
    row: np.ndarray
    problem: Problem
    candidate: int = -1
    picked: np.ndarray | None = None


@dataclass(frozen=True)
class PreparedContender:
    """A contender at its gains.

    Attributes:
        entry: The point that is compared.
        why: Reason of its pick.
        offered: The points of its front, None where nothing was searched.
        folder: Folder of its results, relative to that of the comparison.
        flights: Number of flights of its run.
        search_flights: Number of flights of its search.
        ending: First sentences on a run without a feasible point, else empty.
    """

    entry: ComparedPoint
    why: str
    offered: list[ComparedPoint] | None
    folder: str | None
    flights: int
    warnings: list[str]
    ending: tuple[str, ...] = ()
    search_flights: int = 0

    @property
    def feasible(self) -> bool:
        """Whether the point compared may be flown, according to its run."""
        return not self.ending

    @property
    def contender(self) -> Contender:
        """The contender."""
        return self.entry.contender


@dataclass(frozen=True)
class Flown:
    """scores (contenders, quantities, flights); failed (contenders, flights); origin (flights,): name of the scenario."""

    scores: np.ndarray
    failed: np.ndarray
    origin: np.ndarray

    def samples(self, index: int, scenario: str | None) -> np.ndarray:
        """Return a quantity (contenders, flights) on a scenario, or on all for None."""
        return seen_scores(self.scores, index, self.origin, scenario)


def comparison_problem(study: ComparisonStudy, contender: Contender) -> Problem:
    """Return the problem of a contender in every quantity compared; one flight task at a time."""
    system = contender.study.system
    objectives = tuple(quantity.objective for quantity in study.quantities)
    return Problem(system, DecisionSpace((), (), tuple(contender.study.default_row)), objectives, (), study.seed, 1)


def fly_all(
    study: ComparisonStudy,
    entries: Sequence[ComparedPoint],
    threads: int | None,
    on_flights_done: Callable[[int], None],
) -> Flown:
    """Fly every entry through every scenario of the comparison; the result does not depend on the number of threads."""
    tasks, origin = _tasks(study)
    scores = np.empty((len(entries), len(study.quantities), len(origin)))
    failed = np.empty((len(entries), len(origin)), dtype=bool)

    def fly(task: "_Task") -> None:
        drawn = _draw(study, task)
        columns = slice(task.column, task.column + len(task.indices))
        for k, entry in enumerate(entries):
            inputs = entry.problem.system.with_own_plant(
                drawn, study.base.system, task.scenario.spec, study.seed, study.stream, task.indices
            )
            results = entry.problem.flyer.fly(entry.row[None], entry.problem.system.nominal, inputs)
            values, lost = entry.problem.score(results, task.scenario.spec)
            scores[k, :, columns], failed[k, columns] = values[0], lost[0]
            on_flights_done(len(task.indices))

    with ThreadPoolExecutor(threads or available_threads()) as pool:
        try:
            list(pool.map(fly, tasks))
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return Flown(scores, failed, np.array(origin))


def fly_groups(
    study: ComparisonStudy,
    groups: Sequence[Sequence[ComparedPoint]],
    threads: int | None,
    on_flights_done: Callable[[int], None],
) -> list[Flown]:
    """Fly groups of entries, and return the flights of each group; each scenario is drawn once."""
    flown = fly_all(study, [entry for group in groups for entry in group], threads, on_flights_done)
    ends = np.cumsum([len(group) for group in groups])
    parts = zip(np.split(flown.scores, ends[:-1]), np.split(flown.failed, ends[:-1]), strict=True)
    return [Flown(scores, failed, flown.origin) for scores, failed in parts]


@dataclass(frozen=True)
class _Task:
    scenario: StudyScenario
    indices: range
    column: int


def _tasks(study: ComparisonStudy) -> tuple[list[_Task], list[str]]:
    """Return the chunks of all scenarios and the scenario of each flight."""
    tasks, origin = [], []
    for scenario in study.scenarios:
        for first in range(0, scenario.held_out, CHUNK):
            indices = range(first, min(first + CHUNK, scenario.held_out))
            tasks.append(_Task(scenario, indices, len(origin)))
            origin += [scenario.spec.name] * len(indices)
    return tasks, origin


def _draw(study: ComparisonStudy, task: _Task) -> FlightInputs:
    return study.base.system.sample(task.scenario.spec, study.seed, study.stream, task.indices)
