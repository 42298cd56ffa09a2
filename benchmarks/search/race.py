"""One contestant on one course: it searches until its budget is spent, and its front flies held-out scenarios on the way.

Held-out flights count for nothing, nor does their time. Processor time is that of the search itself, of answering what is
known without flying and of flying.
"""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from time import process_time
from typing import Any, NamedTuple, Protocol

import numpy as np

from benchmarks.search.contestants import Contestant
from benchmarks.search.peer import Array, Start
from benchmarks.search.problems import Course, finalists
from benchmarks.search.process import PeerFailed, PeerProcess
from objectives.problem import Problem
from plant.quadrotor.scenarios import SEARCH
from tuner.experiments.tuning.flight_growth import FlightGrowth
from tuner.experiments.tuning.problem import batches
from tuner.experiments.tuning.search import algorithm_of, study_generations
from tuner.experiments.tuning.survivors import survivors_of
from tuner.search import bayesian_optimization
from tuner.search.front import feasible_front
from tuner.search.loop import Generation, archive
from tuner.search.watcher import Watcher
from tuner.study.study import TuningStudy

# Flights after which a front is judged.
GOALS = (200, 300, 400, 500, 700, 1000, 1500, 2000, 3000, 5000, 11_000, 30_000)


class Step(NamedTuple):
    """A batch that was told: points (n, d), values (n, m), violations (n, c), flights so far, seconds beside this process.

    survivors: whether these are all that the search ends with, on all its flights.
    """

    points: Array
    values: Array
    violations: Array
    flights: int
    elsewhere: float = 0.0
    survivors: bool = False


class Judge(Protocol):
    """Held-out flights."""

    def front(self, points: Array) -> Array:
        """Return the values (k, m) of those points (n, d) that count."""
        ...

    def worth(self, front: Array) -> float | None:
        """Return the worth of a front (k, m)."""
        ...


@dataclass(frozen=True)
class Entry:
    """A front on the way: flights and candidates so far, processor seconds, worth on held-out flights."""

    flights: int
    candidates: int
    seconds: float
    worth: float | None


@dataclass(frozen=True)
class Run:
    """A contestant's run. front: values of its best on held-out flights; stopped: why it ended early, "" where it did not."""

    entries: list[Entry]
    front: list[list[float]]
    stopped: str

    def document(self) -> dict[str, Any]:
        """Return it as JSON-able data."""
        return asdict(self)


def raced(contestant: Contestant, course: Course, envs: Path) -> Run:
    """Run a contestant on a course."""
    study = course.study(contestant.overrides)
    problem = course.problem(study)
    if contestant.peer is None:
        bayesian_optimization.warm_up()
        return judged(tool_steps(problem, study, course.start[: study.search.population]), course, contestant)
    limits = len(study.constraints) + len(study.requirements)
    start = Start(
        course.start[: contestant.first], contestant.batch, course.objectives, limits, course.seed, problem.excess
    )
    with PeerProcess(contestant.peer, start, envs) as peer:
        return judged(peer_steps(problem, study, peer), course, contestant)


def tool_steps(problem: Problem, study: TuningStudy, first: Array) -> Iterator[Step]:
    """Search as the tool does, without a results folder."""
    done: list[Generation] = []
    algorithm = algorithm_of(problem, study, first)
    growth = FlightGrowth(problem, study, algorithm)
    for done in study_generations(growth, algorithm, study.search.budget):
        record = done[-1]
        yield Step(record.points, record.evaluation.values, record.evaluation.violations, record.flights)
    left = survivors_of(problem, growth.study, done, Watcher())
    points, found = archive(done).points[left.candidates], left.evaluation
    yield Step(points, found.values, found.violations, done[-1].flights + left.flights, survivors=True)


def peer_steps(problem: Problem, study: TuningStudy, peer: PeerProcess) -> Iterator[Step]:
    """Ask and tell a peer; what does not fly is told as the worst that did, and violations in shares of their limits."""
    flown, flights, worst = batches(study, SEARCH), 0, None
    limits = np.ones(len(study.constraints) + len(study.requirements))
    limits[: len(study.constraints)] = [entry.most or 1.0 for entry in study.constraints]
    while len(points := peer.ask()):
        found = problem.evaluate(points, flown, fly_all=np.arange(len(points)) == 0 if worst is None else False)
        flights += found.flights
        made = found.values[found.flown]
        worst = np.concatenate([made, made[:0] if worst is None else worst[None]]).max(axis=0)
        peer.tell(np.where(found.flown[:, None], found.values, worst), found.violations / limits)
        yield Step(points, found.values, found.violations, flights, peer.seconds)


def judged(steps: Iterator[Step], judge: Judge, contestant: Contestant) -> Run:
    """Take steps until the budget is spent; the front is judged as the flights reach one goal after the other."""
    meter, record = Meter(), Record(judge)
    goals = [goal for goal in GOALS if goal <= contestant.most_flights]
    stopped = "it asks no more"
    try:
        for step in meter.timed(steps):
            record.add(step)
            seconds = meter.seconds + step.elsewhere
            if step.flights >= goals[0] or step.survivors:
                goals = [goal for goal in goals if goal > step.flights]
                record.judge(seconds)
            if not goals or step.survivors:
                stopped = ""
                break
            if seconds > contestant.most_seconds:
                stopped = f"after {contestant.most_seconds:g} s of a processor"
                break
    except PeerFailed as error:
        stopped = str(error)
    if record.unjudged:
        record.judge(meter.seconds + record.elsewhere)
    return Run(record.entries, record.front.tolist(), stopped)


class Meter:
    """A watch that runs while steps are made and stands while they are judged. seconds: of a processor."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def timed(self, steps: Iterator[Step]) -> Iterator[Step]:
        """Yield the steps."""
        while True:
            begin = process_time()
            step = next(steps, None)
            self.seconds += process_time() - begin
            if step is None:
                return
            yield step


class Record:
    """All that a contestant was told, and how its front was judged. front (k, m): the best of all fronts judged."""

    def __init__(self, judge: Judge) -> None:
        self._judge, self._steps, self._candidates = judge, list[Step](), 0
        self.entries, self.unjudged = list[Entry](), False
        self.front = np.empty((0, 0))

    @property
    def elsewhere(self) -> float:
        """Seconds that a peer took."""
        return self._steps[-1].elsewhere

    def add(self, step: Step) -> None:
        """Take note of a step."""
        if step.survivors:
            self._steps.clear()
        else:
            self._candidates += len(step.points)
        self._steps.append(step)
        self.unjudged = True

    def judge(self, seconds: float) -> None:
        """Judge the front so far."""
        told = [np.concatenate(part) for part in zip(*[step[:3] for step in self._steps], strict=True)]
        front = self._judge.front(finalists(*told))
        self.entries.append(Entry(self._steps[-1].flights, self._candidates, seconds, self._judge.worth(front)))
        every = np.concatenate([front, *([self.front] if len(self.front) else [])])
        self.front = every[feasible_front(every, np.zeros((len(every), 0)))]
        self.unjudged = False
