"""Racing: candidates that are surely not worth it stop after a part of their flights. For searches with costly flights.

Every candidate flies the first quarter of the scenarios, those that are not settled then the second quarter, the rest the
remaining half. A candidate is settled and stops

- where a constraint is broken whatever the flights still to come bring: scores are never negative and risks are monotone, so
  the risk with zeros in place of those flights bounds it from below; or
- where a candidate that flew everything beats it in all objectives in at least LEVEL of the bootstrap resamples of the scenarios
  that both flew, flight by flight.

The values of one that was beaten are those of the candidate that beats it plus what it is worse by so far, so it stays
dominated. After O. Maron, A. W. Moore, "Hoeffding races", NIPS 6, 1994, and M. Birattari, T. Stützle, L. Paquete, K. Varrentrapp,
"A racing algorithm for configuring metaheuristics", GECCO 2002; there with other tests and for one objective.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from objectives.flown_system import FlightBatch
from objectives.problem import Evaluation, Evaluator
from objectives.requirements import known_values, requirement_excess, worth_flying
from objectives.risk.joint import resampled_scenarios, within
from plant.seeds import generator

Array = np.ndarray
# Shares of the scenarios after which candidates are judged, the share of resamples that settles one, number of resamples.
SHARES, LEVEL, REPLICATES = (0.25, 0.5), 0.99, 400
# Candidates whose resamples are worked out together: 64 x 400 x 64 flights are 13 MB.
TOGETHER = 64


@dataclass(frozen=True)
class Champions:
    """The best candidates so far, all of which flew everything: values (k, objectives), scores (k, objectives, flights)."""

    values: Array
    scores: Array


class RaceStages:
    """The flights of a race in stages. counts: for each stage, how many flights of each batch are made at its end."""

    def __init__(self, batches: tuple[FlightBatch, ...]) -> None:
        self.batches = batches
        self.counts = [tuple(max(round(share * batch.count), 1) for batch in batches) for share in (*SHARES, 1.0)]
        self._starts = np.cumsum([0, *[batch.count for batch in batches]])

    @property
    def flights(self) -> int:
        """Number of flights of a candidate that flies everything."""
        return int(self._starts[-1])

    def seen(self, stage: int) -> Array:
        """Return the columns of the flights made until a stage ends."""
        starts = self._starts[:-1]
        return np.concatenate([start + np.arange(n) for start, n in zip(starts, self.counts[stage], strict=True)])

    def origin(self) -> Array:
        """Return the scenario of every flight."""
        return np.repeat([batch.spec.name for batch in self.batches], [batch.count for batch in self.batches])


class Race:
    """One generation's race. settled (n,): who has stopped; stage (n,): after which stage; beaten (n,): by which champion.

    scores (n, quantities, flights), failed (n, flights): 0 where not flown.
    """

    def __init__(
        self, problem: Evaluator, gains: Array, flown: Array, unraced: Array, track: RaceStages, champions: Champions
    ) -> None:
        n = len(gains)
        self.problem, self.gains, self.unraced, self.track, self.champions = problem, gains, unraced, track, champions
        self.settled = ~flown
        self.stage = np.full(n, -1)
        self.beaten = np.full(n, -1)
        self.scores = np.zeros((n, len(problem.quantities), track.flights))
        self.failed = np.zeros((n, track.flights), dtype=bool)

    def run(self, root: int, on_flights_done: Callable[[int], None] | None) -> None:
        """Fly stage after stage and settle who can be settled."""
        for stage in range(len(self.track.counts)):
            running = np.flatnonzero(~self.settled)
            if not len(running):
                break
            self._fly(stage, running, on_flights_done)
            self.stage[running] = stage
            if stage < len(self.track.counts) - 1:
                self._settle(stage, running[~self.unraced[running]], root)

    def _fly(self, stage: int, running: Array, on_flights_done: Callable[[int], None] | None) -> None:
        start = 0
        before = self.track.counts[stage - 1] if stage else tuple(0 for _ in self.track.batches)
        for batch, first, last in zip(self.track.batches, before, self.track.counts[stage], strict=True):
            if last > first:
                columns, all_candidates = slice(start + first, start + last), np.ones(len(running), dtype=bool)
                self.scores[running, :, columns], self.failed[running, columns] = self.problem.scored(
                    self.gains[running], all_candidates, batch, first, last, on_flights_done
                )
            start += batch.count

    def _settle(self, stage: int, running: Array, root: int) -> None:
        hopeless = self.problem.constraint_excess(self.problem.risks(self.scores[running], self.track.origin())) > 0.0
        self.settled[running] = hopeless.any(axis=1)
        seen, open_rows = self.track.seen(stage), running[~self.settled[running]]
        if not len(open_rows) or not len(self.champions.values):
            return
        beaten = beaten_by(
            self.problem,
            self.champions.scores[..., seen],
            self.scores[open_rows][..., seen],
            self.track.origin()[seen],
            root,
        )
        self.beaten[open_rows] = beaten
        self.settled[open_rows] = beaten >= 0

    def conclude(self) -> tuple[Array, Array, Array]:
        """Return the risks (n, quantities), shares of failures (n,) and numbers of flights (n,).

        Scores of flights not made become the mean of the candidate's others in the same scenario.
        """
        n = len(self.gains)
        risks, failures, counted = np.empty(self.scores.shape[:2]), np.ones(n), np.zeros(n, dtype=int)
        for stage in range(-1, len(self.track.counts)):
            rows = np.flatnonzero(self.stage == stage)
            if not len(rows):
                continue
            if stage < 0:
                self._lose(rows)
            seen = self.track.seen(stage) if stage >= 0 else np.arange(self.track.flights)
            risks[rows] = self.problem.risks(self.scores[rows][..., seen], self.track.origin()[seen])
            failures[rows] = self.failed[rows][:, seen].mean(axis=-1)
            counted[rows] = len(seen) if stage >= 0 else 0
            if 0 <= stage < len(self.track.counts) - 1:
                self._put_behind(rows, seen, risks)
                self._fill(rows, stage)
        return risks, failures, counted

    def _lose(self, rows: Array) -> None:
        """Score candidates that failed the screening as failures at t = 0."""
        start = 0
        for batch in self.track.batches:
            columns = slice(start, start + batch.count)
            self.scores[rows, :, columns], self.failed[rows, columns] = self.problem.unflown(batch, batch.count)
            start += batch.count

    def _put_behind(self, rows: Array, seen: Array, risks: Array) -> None:
        lost = rows[self.beaten[rows] >= 0]
        if not len(lost):
            return
        m, winners = len(self.problem.objectives), self.beaten[lost]
        theirs = np.zeros((len(self.champions.values), self.scores.shape[1], len(seen)))
        theirs[:, :m] = self.champions.scores[..., seen]
        so_far = self.problem.risks(theirs, self.track.origin()[seen])[winners, :m]
        risks[lost, :m] = self.champions.values[winners] + np.maximum(risks[lost, :m] - so_far, 0.0)

    def _fill(self, rows: Array, stage: int) -> None:
        start = 0
        for batch, count in zip(self.track.batches, self.track.counts[stage], strict=True):
            made, rest = slice(start, start + count), slice(start + count, start + batch.count)
            self.scores[rows, :, rest] = self.scores[rows, :, made].mean(axis=-1, keepdims=True)
            start += batch.count


def race(
    problem: Evaluator,
    points: Array,
    batches: tuple[FlightBatch, ...],
    champions: Champions,
    root: int,
    on_flights_done: Callable[[int], None] | None = None,
    fly_all: bool | Array = False,
) -> Evaluation:
    """Evaluate points (n, d) of the unit cube like `Evaluator.evaluate`, with early stops.

    fly_all: who flies everything whatever happens.
    """
    begin = problem.now()
    gains, unraced = problem.space.gains(points), np.broadcast_to(fly_all, len(points))
    screening_values = known_values(problem.screens, gains)
    screened = problem.now()
    flown = worth_flying(problem.requirements, screening_values) | unraced
    track = RaceStages(batches)
    run = Race(problem, gains, flown, unraced, track, champions)
    run.run(root, on_flights_done)
    risks, failures, counted = run.conclude()
    problem.spare(len(points) * track.flights - int(counted.sum(axis=0)), on_flights_done)
    return Evaluation(
        values=risks[:, : len(problem.objectives)],
        excess=np.concatenate(
            [problem.constraint_excess(risks), requirement_excess(problem.requirements, screening_values)], axis=1
        ),
        failures=failures,
        scores=run.scores,
        origin=track.origin(),
        requirements=screening_values,
        flown=flown,
        counted=counted,
        screening_seconds=screened - begin,
        flight_seconds=problem.now() - screened,
    )


def beaten_by(problem: Evaluator, champions: Array, scores: Array, origin: Array, root: int) -> Array:
    """Return the champion that surely beats each candidate (n,), -1 for none.

    champions (k, objectives, flights), scores (n, quantities, flights): of the same flights, of scenarios origin (flights,).
    """
    drawn = resampled_scenarios(generator(root, "racing", len(origin)), REPLICATES, origin)
    theirs = np.concatenate([_resampled(problem, part, origin, drawn) for part in _few(champions)], axis=1)
    beaten = [_surely_beaten(_resampled(problem, part, origin, drawn), theirs) for part in _few(scores)]
    return np.concatenate(beaten, axis=0)


def _few(scores: Array) -> list[Array]:
    """Split scores (n, ...) into parts of few candidates: their resamples are REPLICATES times as large."""
    return [scores[start : start + TOGETHER] for start in range(0, len(scores), TOGETHER)]


def _resampled(problem: Evaluator, scores: Array, origin: Array, drawn: Array) -> Array:
    """Return the objectives (objectives, n, replicates) of candidates on resampled flights."""
    risks = np.empty((len(problem.objectives), len(scores), REPLICATES))
    for i, objective in enumerate(problem.objectives):
        seen = slice(None) if objective.scenario is None else origin == objective.scenario
        risks[i] = objective.risk.apply(scores[:, i, seen][:, within(drawn, origin, objective.scenario)])
    return risks


def _surely_beaten(mine: Array, theirs: Array) -> Array:
    """Return the index (n,) of the champion that surely beats each candidate.

    It is one of theirs (objectives, k, replicates), -1 for none.
    """
    share = np.all(mine[:, :, None] > theirs[:, None], axis=0).mean(axis=-1)
    best = share.argmax(axis=1)
    return np.where(share[np.arange(len(best)), best] >= LEVEL, best, -1)
