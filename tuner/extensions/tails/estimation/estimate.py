"""The estimate of a tail: replicas until the interval is narrow, and how that ended."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from objectives.risk.measures import Interval
from objectives.risk.shares import clopper_pearson, upper_bound
from plant.seeds import generator
from tuner.extensions.tails.estimation.crude import BATCH, count_failures
from tuner.extensions.tails.estimation.intervals import FIRST, mean_interval, ratio_interval, replicas_needed, upper_end
from tuner.extensions.tails.estimation.limit_function import (
    Array,
    Curve,
    LimitFunction,
    Method,
    ModeEstimate,
    OnProgress,
    Progress,
    Replica,
    Status,
    TailEstimate,
)
from tuner.extensions.tails.estimation.planning import Plan, Request, limit_of, plan_tail, replicas_at_once
from tuner.extensions.tails.estimation.splitting import evaluate, replica_evaluations, replicate, run_together

AT_ONCE = 16
"""Replicas evaluated side by side, where memory allows."""


class ReplicaRunner(Protocol):
    """Runs replicas of a plan, wherever: each is a function of limit function, plan, seed and number alone."""

    def at_once(self, plan: Plan) -> int:
        """Return the number of replicas that are run together."""
        ...

    def run(self, plan: Plan, numbers: Sequence[int]) -> list[Replica]:
        """Return the replicas of some numbers, in their order."""
        ...


@dataclass(frozen=True)
class LocalReplicas:
    """Replicas on this machine."""

    limit: LimitFunction
    seed: int

    def at_once(self, plan: Plan) -> int:
        """Return the number of replicas whose states fit into memory."""
        return replicas_at_once(plan, self.limit.dimension, AT_ONCE)

    def run(self, plan: Plan, numbers: Sequence[int]) -> list[Replica]:
        """Return the replicas of some numbers, in their order."""
        samplers = [
            replicate(number, self.limit.dimension, plan.ladders, plan.curve, stream(self.seed, number))
            for number in numbers
        ]
        return run_together(limit_of(self.limit, plan), samplers)


def stream(seed: int, number: int) -> np.random.Generator:
    """Return the generator of a replica."""
    return generator(seed, "tail/replica", number)


def estimate_tail(
    limit: LimitFunction,
    seed: int,
    request: Request,
    plan: Plan | None = None,
    completed: Sequence[Replica] = (),
    on_progress: OnProgress | None = None,
    runner: ReplicaRunner | None = None,
) -> TailEstimate:
    """Return the probability that a limit function reaches 1, with its interval.

    Args:
        limit: limit function.
        seed: root of all streams.
        request: width, smallest probability and evaluations allowed.
        plan: plan of `plan_tail` for the same arguments, where it is at hand.
        completed: replicas of the same arguments, which are not run again.
        on_progress: called with each replica.
        runner: runner of the replicas of splitting, by default this machine.
    """
    plan = plan or plan_tail(limit, seed, request)
    replicas = _Replicas(limit, seed, request, plan, completed, on_progress, runner or LocalReplicas(limit, seed))
    match plan.method:
        case Method.EVALUATION:
            return _decided(limit, request)
        case Method.CRUDE:
            return _counted(replicas)
        case Method.SPLITTING:
            return _split(replicas)


class _Replicas:
    """The replicas of a plan, in order, each run once."""

    def __init__(
        self,
        limit: LimitFunction,
        seed: int,
        request: Request,
        plan: Plan,
        completed: Sequence[Replica],
        on_progress: OnProgress | None,
        runner: ReplicaRunner,
    ) -> None:
        self.limit, self.seed, self.request, self.plan = limit, seed, request, plan
        self.expected = FIRST
        self.done: list[Replica] = []
        self._completed = {replica.number: replica for replica in completed}
        self._on_progress, self._runner = on_progress, runner

    @property
    def evaluations(self) -> int:
        """Return the rows evaluated, pilot included."""
        return self.plan.evaluations + sum(replica.evaluations for replica in self.done)

    @property
    def rows_left(self) -> int:
        """Return the rows that may still be evaluated."""
        return self.request.most_evaluations - self.evaluations

    def extend(self, count: int) -> None:
        """Run replicas up to a count, or while rows last."""
        self.expected = count
        at_once = self._runner.at_once(self.plan)
        while len(self.done) < count:
            fitting = self.rows_left // replica_evaluations(self.plan.ladders)
            if fitting <= 0:
                return
            begin = len(self.done)
            part = range(begin, min(begin + min(at_once, fitting), count))
            missing = [number for number in part if number not in self._completed]
            self._completed |= dict(zip(missing, self._runner.run(self.plan, missing), strict=True))
            for number in part:
                self._add(self._completed[number])

    def count_batch(self) -> None:
        """Run a batch of crude Monte Carlo."""
        number, rows = len(self.done), min(BATCH, self.rows_left)
        replica = self._completed.get(number)
        if replica is None or replica.evaluations != rows:
            replica = count_failures(self.limit, number, rows, self.plan.curve, stream(self.seed, number))
        self._add(replica)

    def _add(self, replica: Replica) -> None:
        self.done.append(replica)
        if self._on_progress is not None:
            part = self.evaluations - self.plan.evaluations
            expected = self.plan.evaluations + part * max(self.expected, len(self.done)) // len(self.done)
            self._on_progress(Progress(replica, *self._interval(), self.evaluations, expected))

    def _interval(self) -> tuple[float, float, float]:
        values = np.array([replica.probability for replica in self.done])
        if self.plan.method is Method.CRUDE:
            hits, rows = _hits(self.done)
            low, high = clopper_pearson(hits, rows, self.request.confidence)
            return hits / rows, float(low), float(high)
        if len(values) < 2:
            return float(values[0]), 0.0, 1.0
        low, high = mean_interval(values, self.request.confidence)
        return float(np.mean(values)), float(low), float(high)


def _decided(limit: LimitFunction, request: Request) -> TailEstimate:
    """Return 0 or 1 of a limit function without randomness."""
    values = evaluate(limit, np.empty((1, 0)))[0]
    fails = float(np.max(values) >= 1.0)
    modes = tuple(
        ModeEstimate(name, float(value >= 1.0), _exactly(value >= 1.0), float(value >= 1.0), _exactly(value >= 1.0))
        for name, value in zip(limit.modes, values, strict=True)
    )
    curve = Curve(np.ones(1), *[np.array([fails])] * 3)
    return TailEstimate(
        Status.DETERMINISTIC, Method.EVALUATION, fails, fails, fails, request.confidence, 1, (), modes, curve
    )


def _exactly(value: float) -> Interval:
    return Interval(np.asarray(float(value)), np.asarray(float(value)))


def _counted(run: _Replicas) -> TailEstimate:
    """Return the estimate by crude Monte Carlo: batches until the interval of Clopper and Pearson is narrow."""
    request, level = run.request, run.request.confidence
    status, hits, rows = Status.WIDE, 0, 0
    while run.rows_left > 0:
        run.count_batch()
        hits, rows = _hits(run.done)
        low, high = clopper_pearson(hits, rows, level)
        if hits == 0 and upper_bound(0, rows, level) <= request.smallest:
            status = Status.BELOW
            break
        if 0 < hits < rows and high - low <= request.relative_width * hits / rows:
            status = Status.ESTIMATED
            break
        if hits == rows and 1.0 - low <= 0.001:
            break
    low, high = map(float, clopper_pearson(hits, rows, level))
    if hits == 0:
        low, high = 0.0, upper_bound(0, rows, level)
    elif hits == rows:
        status, low, high = Status.CERTAIN, 1.0 - upper_bound(0, rows, level), 1.0
    batches = np.array([replica.evaluations for replica in run.done])
    failed = np.rint(batches @ np.array([replica.ladders for replica in run.done])).astype(int)
    reached = np.rint(batches @ np.array([replica.curve for replica in run.done])).astype(int)
    modes = tuple(
        ModeEstimate(name, k / rows, clopper_pearson(k, rows, level), k / max(hits, 1), clopper_pearson(k, hits, level))
        for name, k in zip(run.limit.modes, failed.tolist(), strict=True)
    )
    curve = Curve(run.plan.curve, reached / rows, *clopper_pearson(reached, rows, level))
    return TailEstimate(
        status, Method.CRUDE, hits / rows, low, high, level, run.evaluations, tuple(run.done), modes, curve
    )


def _hits(batches: Sequence[Replica]) -> tuple[int, int]:
    """Return the failures and the rows of batches."""
    rows = sum(batch.evaluations for batch in batches)
    return round(sum(batch.probability * batch.evaluations for batch in batches)), rows


def _split(run: _Replicas) -> TailEstimate:
    """Return the estimate by splitting: the first replicas say how many it takes."""
    request, level = run.request, run.request.confidence
    is_reached = any(ladder.target == 1.0 for ladder in run.plan.ladders)
    wanted, status = FIRST, Status.WIDE
    while run.plan.ladders:
        before = len(run.done)
        run.extend(wanted)
        if not is_reached or len(run.done) < max(wanted, 2):
            break
        values = _probabilities(run.done)
        if np.all(values == 0.0):
            break
        low, high = mean_interval(values, level)
        if high - low <= request.relative_width * np.mean(values):
            status = Status.ESTIMATED
            break
        variation = float(np.std(values, ddof=1) / np.mean(values))
        wanted = replicas_needed(variation, request.relative_width, level)
        # A second extension is rare, and not one by one, or the interval would be stopped when it happens to be narrow.
        wanted = max(wanted, len(run.done) + (len(run.done) // 4 if before else 1))
    if not is_reached:
        return _bounded(run)
    values = _probabilities(run.done)
    probability = float(np.mean(values)) if len(values) else 0.0
    low, high = map(float, mean_interval(values, level)) if len(values) > 1 else (0.0, 1.0)
    if probability == 0.0:
        high = upper_bound(0, run.plan.independent, level)
    return TailEstimate(
        status,
        Method.SPLITTING,
        probability,
        low,
        high,
        level,
        run.evaluations,
        tuple(run.done),
        _modes(run),
        _curve(run),
    )


def _probabilities(replicas: Sequence[Replica]) -> Array:
    return np.array([replica.probability for replica in replicas])


def _bounded(run: _Replicas) -> TailEstimate:
    """Return a bound where no ladder reached the event: the probability of the demand that was reached."""
    level = run.request.confidence
    high = upper_bound(0, run.plan.independent, level)
    # A mode without any ladder is bounded by the rows alone.
    if len(run.done) > 1 and len(run.plan.ladders) >= len(run.limit.modes):
        high = min(high, upper_end(np.sum([replica.ladders for replica in run.done], axis=1), level))
    status = Status.UNREACHED if run.plan.is_stalled else Status.BELOW
    return TailEstimate(
        status, Method.SPLITTING, 0.0, 0.0, high, level, run.evaluations, tuple(run.done), _modes(run), _curve(run)
    )


def _modes(run: _Replicas) -> tuple[ModeEstimate, ...]:
    """Return the estimate of each mode: of its ladder, or of those of its sectors."""
    level, names = run.request.confidence, run.limit.modes
    owners = [*range(len(names)), *(sector.mode for sector in run.plan.sectors)]
    per_mode = np.zeros((len(run.done), len(names)))
    for place, ladder in enumerate(run.plan.ladders):
        if ladder.target == 1.0:
            per_mode[:, owners[ladder.mode]] += [replica.ladders[place] for replica in run.done]
    events = _probabilities(run.done)
    return tuple(
        _mode(name, values, events, level) if np.any(values) else _unreached(name, run.plan.independent, level)
        for name, values in zip(names, per_mode.T, strict=True)
    )


def _mode(name: str, values: Array, events: Array, level: float) -> ModeEstimate:
    """Return a mode's estimate from replicas of it and of the event."""
    if len(values) < 2:
        anything = Interval(np.asarray(0.0), np.asarray(1.0))
        return ModeEstimate(name, float(values[0]), anything, 1.0, anything)
    # A mode and the event are estimated apart, and a mode is a part of the event.
    share, low, high = (
        np.minimum(part, 1.0) for part in (np.mean(values) / np.mean(events), *ratio_interval(values, events, level))
    )
    return ModeEstimate(name, float(np.mean(values)), mean_interval(values, level), float(share), Interval(low, high))


def _unreached(name: str, rows: int, level: float) -> ModeEstimate:
    """Return the bound of a mode without failures in these rows."""
    bound = Interval(np.asarray(0.0), np.asarray(upper_bound(0, rows, level)))
    return ModeEstimate(name, 0.0, bound, 0.0, Interval(np.asarray(0.0), np.asarray(1.0)))


def _curve(run: _Replicas) -> Curve:
    """Return the probabilities of the levels on the way."""
    if len(run.done) < 2:
        return Curve(*[np.empty(0)] * 4)
    counted = np.array([replica.curve for replica in run.done])
    return Curve(run.plan.curve, np.mean(counted, axis=0), *mean_interval(counted, run.request.confidence))
