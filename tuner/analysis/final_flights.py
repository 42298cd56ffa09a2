"""Held-out flights of finalists, of which some stop early, and their estimates.

The value of a finalist that stopped is its paired difference to one that made all flights, from the flights of both, plus the
value of that one: points that lie close together rise and fall with the air alike, so their difference varies far less than
their values (control variates: P. Glasserman, "Monte Carlo Methods in Financial Engineering", Springer, 2003, section 4.1). Its
intervals are wider by as much as it flew less. Shares rest on its own flights alone, where their intervals are exact.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from objectives.problem import Evaluation, Evaluator, seen_scores
from objectives.requirements import requirement_excess
from objectives.risk import PairedDifference, Risk, replicates_on, within
from objectives.risk.joint import resampled_scenarios
from plant.seeds import generator

Array = np.ndarray
# Resamples of the flights, the same for all finalists and questions; complete rows that may stand in for one that stopped.
FRONT_REPLICATES, NEIGHBOURS = 400, 3


@dataclass(frozen=True)
class FinalFlights:
    """Held-out flights of finalists.

    Attributes:
        problem: Evaluator of the flights.
        root: Root seed.
        scores (rows, quantities, flights): Scores; a skipped flight has the mean of those made in the same scenario.
        failed (rows, flights): Mask of the failed flights.
        origin (flights,): Name of the scenario.
        requirements (rows, requirements): Values of the requirements.
        early (flights,): Mask of the flights that all rows made.
        complete (rows,): Mask of the rows that made all flights.
    """

    problem: Evaluator
    root: int
    scores: Array
    failed: Array
    origin: Array
    requirements: Array
    early: Array
    complete: Array
    seconds: float = 0.0
    _estimates: dict[tuple[int, float], tuple[Array, Array, Array]] = field(default_factory=dict, init=False)
    _differences: dict[tuple[int, float], tuple[Array, PairedDifference]] = field(default_factory=dict, init=False)

    @cached_property
    def evaluation(self) -> Evaluation:
        """The values of every row."""
        n = len(self.problem.objectives)
        risks = np.stack([self.value(i) for i in range(self.scores.shape[1])], axis=1)
        over = requirement_excess(self.problem.requirements, self.requirements)
        return Evaluation(
            values=risks[:, :n],
            excess=np.concatenate([self.problem.constraint_excess(risks), over], axis=1),
            failures=np.where(self.complete, self.failed.mean(axis=1), self.failed[:, self.early].mean(axis=1)),
            scores=self.scores,
            origin=self.origin,
            requirements=self.requirements,
            flown=np.ones(len(risks), dtype=bool),
            counted=np.where(self.complete, len(self.early), int(self.early.sum(axis=0))),
            flight_seconds=self.seconds,
        )

    def value(self, i: int) -> Array:
        """Return the risk of a quantity (rows,)."""
        (samples, _, risk), stopped = self.seen(i), ~self.complete
        estimates = np.empty(len(samples))
        estimates[self.complete] = risk.apply(samples[self.complete])
        if stopped.any():
            early, nearest = risk.apply(self.seen(i, early=True)[0]), self._nearest_complete(i)
            carried = estimates[nearest] + early[stopped] - early[nearest]
            estimates[stopped] = early[stopped] if self.problem.quantities[i].is_binary else carried
        return estimates

    def estimate(self, i: int, confidence: float = 0.95) -> tuple[Array, Array, Array]:
        """Return the risk of a quantity (rows,) and both ends of its interval."""
        if (i, confidence) not in self._estimates:
            quantity, (samples, drawn, risk) = self.problem.quantities[i], self.seen(i)
            full = samples[self.complete]
            if quantity.is_binary:
                ends = [
                    quantity.interval(part, drawn, confidence)
                    for part in (full, self.seen(i, early=True)[0][~self.complete])
                ]
                low, high = self._merged(*ends)
                estimates = self.value(i), low, high
            else:
                of_complete = risk.apply(full), *quantity.interval(full, drawn, confidence)
                estimates = self._carried(i, confidence, *of_complete)
            self._estimates[i, confidence] = estimates
        return self._estimates[i, confidence]

    def difference_to(self, i: int, row: int) -> PairedDifference:
        """Return the paired differences (rows,) of a risk to a complete row."""
        quantity, (samples, drawn, _) = self.problem.quantities[i], self.seen(i)
        differences = quantity.difference(samples[self.complete], samples[row], drawn)
        if quantity.is_binary:
            early = self.seen(i, early=True)[0]
            parts = self._merged(differences, quantity.difference(early[~self.complete], early[row], drawn))
            # From itself it differs by nothing, whatever was not seen.
            return PairedDifference(*[np.where(np.arange(len(part)) == row, 0.0, part) for part in parts])
        return PairedDifference(*self._carried(i, 0.95, *differences))

    def replicates(self, i: int) -> Array:
        """Return the risk of a quantity on every resample (rows, FRONT_REPLICATES)."""
        samples, drawn, risk = self.seen(i)
        estimates, stopped = np.empty((len(samples), len(drawn))), np.flatnonzero(~self.complete)
        estimates[self.complete] = replicates_on(samples[self.complete], risk, drawn)
        if len(stopped):
            samples, drawn, _ = self.seen(i, early=True)
            nearest = self._nearest_complete(i)
            distinct, rows = np.unique(nearest, return_inverse=True)
            differences = (
                replicates_on(samples[stopped], risk, drawn) - replicates_on(samples[distinct], risk, drawn)[rows]
            )
            estimates[stopped] = estimates[nearest] + differences
        return estimates

    def non_dominated(self, rows: Array) -> Array:
        """Return the mask (k,) of the non-dominated rows (k,): each pair on the flights that both made."""
        n = len(self.problem.objectives)
        full = np.stack([risk.apply(samples) for samples, _, risk in map(self.seen, range(n))], axis=1)[rows]
        parts = [self.seen(i, early=True) for i in range(n)]
        early = np.stack([risk.apply(samples) for samples, _, risk in parts], axis=1)[rows]
        both = self.complete[rows] & self.complete[rows][:, None]
        worse = [dominates(values[:, None], values) for values in (full, early)]
        return ~np.any(np.where(both, *worse), axis=0)

    def seen(self, i: int, early: bool = False) -> tuple[Array, Array, Risk]:
        """Return scores (rows, flights) of a quantity, resamples of these flights, and its risk.

        early: on the flights that everyone made.
        """
        quantity, scores, origin, drawn = self.problem.quantities[i], self.scores, self.origin, self._drawn
        if early:
            scores, origin, drawn = scores[..., self.early], origin[self.early], self._drawn_early
        return (
            seen_scores(scores, i, origin, quantity.scenario),
            within(drawn, origin, quantity.scenario),
            quantity.risk,
        )

    def _stand_ins(self, i: int, confidence: float = 0.95) -> tuple[Array, PairedDifference]:
        """Return the complete rows nearest to the stopped rows, and the differences.

        The differences (stopped,) are of one quantity: stopped row minus its nearest complete row.
        """
        if (i, confidence) not in self._differences:
            nearest, (samples, drawn, _) = self._nearest_complete(i), self.seen(i, early=True)
            differences = self.problem.quantities[i].difference(
                samples[~self.complete], samples[nearest], drawn, confidence
            )
            self._differences[i, confidence] = nearest, differences
        return self._differences[i, confidence]

    def _merged(self, complete: tuple[Array, ...], stopped: tuple[Array, ...]) -> list[Array]:
        """Return numbers of all rows from those of complete and stopped rows."""
        out = [np.empty(len(self.complete)) for _ in complete]
        for full, one, other in zip(out, complete, stopped, strict=True):
            full[self.complete], full[~self.complete] = one, other
        return out

    def _nearest_complete(self, i: int) -> Array:
        """Return for each stopped row the complete row nearest in a quantity.

        Of those that are the fewest places away, added up over the objectives, the one with the smallest variance in all: what
        went wrong in a few late flights of one must not count for the others.
        """
        complete, (full, *_), (early, *_) = self._sound, self.seen(i), self.seen(i, early=True)
        variance = full[complete].var(axis=-1) / full.shape[-1]
        near = np.argsort(self._places_apart[:, complete], axis=1, kind="stable")[:, :NEIGHBOURS]
        estimates = []
        for row, some in zip(np.flatnonzero(~self.complete), near[~self.complete], strict=True):
            differences = (early[row] - early[complete[some]]).var(axis=-1) / early.shape[-1]
            estimates.append(complete[some[np.argmin(variance[some] + differences)]])
        return np.array(estimates)

    @cached_property
    def _sound(self) -> Array:
        """The complete rows that satisfy all constraints, or else all complete rows."""
        complete = np.flatnonzero(self.complete)
        broken = self.problem.constraint_excess(self.problem.risks(self.scores[complete], self.origin))
        sound = complete[np.all(broken <= 0.0, axis=1)]
        return sound if len(sound) else complete

    @cached_property
    def _places_apart(self) -> Array:
        """Distances (rows, rows) in rank, added up over the objectives.

        The ranks are from the flights that all rows made.
        """
        parts = [self.seen(i, early=True) for i in range(len(self.problem.objectives))]
        order = [np.argsort(risk.apply(samples), kind="stable") for samples, _, risk in parts]
        places = np.argsort(np.stack(order), axis=1)
        return np.abs(places[:, :, None] - places[:, None]).sum(axis=0)

    @cached_property
    def _drawn(self) -> Array:
        return resampled_scenarios(generator(self.root, "bootstrap/front", 0), FRONT_REPLICATES, self.origin)

    @cached_property
    def _drawn_early(self) -> Array:
        draw = generator(self.root, "bootstrap/finals", 0)
        return resampled_scenarios(draw, FRONT_REPLICATES, self.origin[self.early])

    def _carried(self, i: int, confidence: float, *of_complete: Array) -> tuple[Array, Array, Array]:
        """Return values and intervals of all rows from those of complete ones."""
        value, low, high = np.empty((3, len(self.complete)))
        value[self.complete], low[self.complete], high[self.complete] = of_complete
        stopped = np.flatnonzero(~self.complete)
        if len(stopped):
            nearest, differences = self._stand_ins(i, confidence)
            value[stopped], low[stopped], high[stopped] = carried(
                (value[nearest], low[nearest], high[nearest]), differences
            )
        return value, low, high


def carried(other: tuple[Array, Array, Array], differences: PairedDifference) -> tuple[Array, Array, Array]:
    """Return values and intervals (rows,) by differences to others.

    Distances to ends add as variances do: G. Y. Zou, A. Donner, Statistics in Medicine 27(10):1693-1702, 2008, for a sum.
    """
    value = other[0] + differences.difference
    below = np.hypot(other[0] - other[1], differences.difference - differences.low)
    above = np.hypot(other[2] - other[0], differences.high - differences.difference)
    return value, value - below, value + above


def dominates(one: Array, other: Array, axis: int = -1) -> Array:
    """Return True where one set of objectives, along an axis, dominates another."""
    return np.all(one <= other, axis=axis) & np.any(one < other, axis=axis)
