"""The truth about the finalists: re-flown on scenarios that the search never saw, with intervals over scenarios.

Every finalist meets the same scenarios, and one resample of them serves all finalists and objectives, so that comparisons of two
candidates, or of the whole front, are paired. The recommended point is picked on these values, which flatters it; it and the
default are flown once more on scenarios that decided nothing, and the comparison of the two uses those. Measured on straight
fronts of 12 and 48 points of lognormal values with 1024 flights (CVaR 0.8, 300 repetitions): 95 % intervals on the values it was
picked by hold its true value in 72 to 91 % and its difference to the default in 81 to 89 %, those on fresh flights both in 93 to
95 %.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

import numpy as np

from objectives.problem import Constraint, Evaluation, Evaluator, Objective
from objectives.requirements import Requirement, WorstState, known_values, worst_states
from objectives.risk import (
    RELEVANT,
    RISKS,
    PairedDifference,
    resampled_scenarios,
    within,
)
from plant.seeds import generator
from tuner.analysis.final_flights import FRONT_REPLICATES, FinalFlights
from tuner.documents.parts import Estimate, SampledValue, ShareCount
from tuner.documents.summary import ComparedRow, ComparedState, RequiredRow
from tuner.documents.verdicts import BROKEN, SATISFIED, verdict_on_difference, verdict_on_limit
from tuner.search.front import non_dominated

# Bootstrap replicates for the Default / Tuned table.
TABLE_REPLICATES = 2000


@dataclass(frozen=True)
class Finalists:
    """Held-out results; row 0 is the default, the others are the front of the search.

    FINALIST_COLUMNS names the columns that are written.

    Attributes:
        flown: Flights of all rows; evaluation: their values.
        low, high (rows, objectives): Intervals.
        limits (3, rows, constraints): Values of constrained quantities with both ends of the intervals that decide.
        excess (rows, constraints + requirements): Beyond each limit at its confidence, 0 where satisfied.
        feasible: Mask over the rows.
        non_dominated: Mask over the rows, among the feasible rows behind the default.
        search: Values of the search.
        gap (rows, objectives): Held-out minus search, with gap_low, gap_high.
        probability (rows,): Share of the resamples on which the row is non-dominated among the feasible rows behind the default,
            0 for the others.
        difference (rows, objectives): Row minus default, paired, with difference_low, difference_high.
    """

    flown: FinalFlights
    low: np.ndarray
    high: np.ndarray
    limits: np.ndarray
    excess: np.ndarray
    feasible: np.ndarray
    non_dominated: np.ndarray
    search: np.ndarray
    gap: np.ndarray
    gap_low: np.ndarray
    gap_high: np.ndarray
    probability: np.ndarray
    difference: np.ndarray
    difference_low: np.ndarray
    difference_high: np.ndarray

    @property
    def evaluation(self) -> Evaluation:
        """The values of all rows."""
        return self.flown.evaluation

    @property
    def flights(self) -> np.ndarray:
        """Number of held-out flights of each row."""
        return self.evaluation.flights_each

    @property
    def lost(self) -> np.ndarray:
        """Held-out flights of each row that did not reach their end."""
        return self.evaluation.lost


@dataclass(frozen=True)
class SearchEstimate:
    """A finalist as the search saw it: values (objectives,), scores (quantities, flights), scenario of each flight."""

    values: np.ndarray
    scores: np.ndarray
    origin: np.ndarray

    def samples(self, index: int, scenario: str | None) -> np.ndarray:
        """Return the scores (flights,) of a quantity in one scenario or all."""
        return self.scores[index] if scenario is None else self.scores[index][self.origin == scenario]


def judge(flown: FinalFlights, searched: list[SearchEstimate], limits: np.ndarray, limited: np.ndarray) -> Finalists:
    """Judge all finalists by their held-out flights.

    Args:
        flown: The flights.
        searched: Each finalist in the search.
        limits: See `Finalists`.
        limited: Excess (rows, constraints) at each limit's confidence, 0 where it is kept.
    """
    evaluation, problem, root = flown.evaluation, flown.problem, flown.root
    shape = evaluation.values.shape
    low, high, search, gap_low, gap_high = (np.empty(shape) for _ in range(5))
    replicates = np.empty((*shape, FRONT_REPLICATES))
    for i, objective in enumerate(problem.objectives):
        _, low[:, i], high[:, i] = flown.estimate(i)
        replicates[:, i] = flown.replicates(i)
        before = [entry.samples(i, objective.scenario) for entry in searched]
        search[:, i] = [entry.values[i] for entry in searched]
        ends = [_search_interval(entry, objective, root, i) for entry in before]
        gap_low[:, i], gap_high[:, i] = gap_interval(
            evaluation.values[:, i], low[:, i], high[:, i], search[:, i], *np.array(ends).T
        )
    split = len(problem.constraints)
    excess = np.array(evaluation.violations)
    excess[:, :split] = limited
    feasible = np.all(excess <= 0.0, axis=1)
    best, probability = np.zeros(shape[0], dtype=bool), np.zeros(shape[0])
    rows = 1 + np.flatnonzero(feasible[1:])
    best[rows] = flown.non_dominated(rows)
    probability[rows] = share_non_dominated(replicates[rows])
    return Finalists(
        flown,
        low,
        high,
        limits,
        excess,
        feasible,
        best,
        search,
        evaluation.values - search,
        gap_low,
        gap_high,
        probability,
        *differences_to(flown, 0),
    )


def differences_to(flown: FinalFlights, row: int) -> PairedDifference:
    """Return the paired differences (rows, objectives) of every finalist to a complete one.

    They are taken over the held-out flights.
    """
    differences = [flown.difference_to(i, row) for i in range(len(flown.problem.objectives))]
    return PairedDifference(*np.stack(differences, axis=-1))


def _search_interval(samples: np.ndarray, objective: Objective, root: int, index: int) -> tuple[float, float]:
    draw = generator(root, "bootstrap/search", index)
    low, high = objective.interval(
        samples, draw.integers(len(samples), size=(FRONT_REPLICATES, len(samples)), dtype=np.intp)
    )
    return float(low), float(high)


def gap_interval(
    value: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    other: np.ndarray,
    other_low: np.ndarray,
    other_high: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Return both ends of the interval of value - other.

    They come from the intervals of the two, which are estimated on different scenarios.
    G. Y. Zou, A. Donner, "Construction of confidence limits about effect measures", Statistics in Medicine
    27(10):1693-1702, 2008 (MOVER): the distances from the estimates to their limits add as variances do.
    """
    gap_sizes = value - other
    return (
        gap_sizes - np.hypot(value - low, other_high - other),
        gap_sizes + np.hypot(high - value, other - other_low),
    )


def share_non_dominated(replicates: np.ndarray) -> np.ndarray:
    """Return the share (rows,) of resamples in which each row is non-dominated.

    replicates (rows, objectives, resamples).
    """
    count = replicates.shape[-1]
    fronts = [non_dominated(np.ascontiguousarray(replicates[..., r])) for r in range(count if len(replicates) else 0)]
    return np.mean(np.array(fronts, dtype=float).reshape(-1, len(replicates)), axis=0) if fronts else np.zeros(0)


def compare(
    problem: Evaluator,
    flown: Evaluation,
    root: int,
    relevant: float = RELEVANT,
    costs: np.ndarray | None = None,
) -> list[ComparedRow]:
    """Compare the second row of an evaluation with the first, paired.

    It returns a row for every objective and constraint, paired by flight.
    relevant: share of the default's value from which a difference matters. costs (quantities,): of a flight that is lost at once.
    """
    rows = []
    limits = [*[None] * len(problem.objectives), *problem.constraints]
    drawn = resampled_scenarios(generator(root, "bootstrap/table", 0), TABLE_REPLICATES, flown.origin)
    for i, (quantity, limit) in enumerate(zip(problem.quantities, limits, strict=True)):
        samples = flown.samples(i, quantity.scenario)
        part = within(drawn, flown.origin, quantity.scenario)
        values = quantity.risk.apply(samples)
        low, high = quantity.interval(samples, part)
        if costs is not None:
            high = np.minimum(high, largest_values(quantity, samples, float(costs[i])))
        default, tuned = (Estimate(float(values[k]), float(low[k]), float(high[k])) for k in (0, 1))
        gap_sizes = SampledValue(*map(float, quantity.difference(samples[1], samples[0], part)))
        if np.min(samples) >= 0.0:
            gap_sizes = within_values(gap_sizes, float(high[0]), float(high[1]))
        row = compared_row(quantity, default, tuned, gap_sizes, limit, relevant)
        if limit is not None and row.verdict == SATISFIED and not limit.rests_on_value:
            end = float(quantity.interval(samples[1], part, limit.confidence).high)
            row = row.model_copy(update={"verdict": verdict_on_limit(tuned.value, limit.most, high=end)})
        counts = [ShareCount.of(one) for one in samples] if quantity.is_binary else []
        rows.append(row.model_copy(update=dict(zip(("default_count", "tuned_count"), counts, strict=False))))
    return rows


def largest_values(quantity: Objective, samples: np.ndarray, cost: float) -> np.ndarray:
    """Return the largest risks (rows,) that samples (rows, flights) can come from.

    That of flights of which none is lost, or of lost ones. cost: of one that is lost at once, see `objectives.metrics.evaluate`.
    """
    bound = 0.5 * cost if quantity.metric.metric.graded else cost
    return np.where(np.max(samples, axis=-1) <= bound, bound, cost)


def within_values(difference: SampledValue, default: float, tuned: float) -> SampledValue:
    """Return a difference of two risks with ends that it can have."""
    value, low, high = difference
    return SampledValue(value, max(low, -max(default, -value)), min(high, max(tuned, value)))


def compared_row(
    quantity: Objective,
    default: Estimate,
    tuned: Estimate,
    difference: SampledValue,
    limit: Constraint | None = None,
    relevant: float = RELEVANT,
) -> ComparedRow:
    """Return one line of the Default / Tuned table, judged by values; difference: tuned minus default, paired over scenarios."""
    if limit is None:
        verdict = verdict_on_difference(default.value, difference, relevant)
    else:
        verdict = verdict_on_limit(float(tuned.value or 0.0), limit.most)
    return ComparedRow(
        label=quantity.label,
        metric=quantity.metric.text,
        definition=quantity.metric.metric.definition,
        risk=RISKS[quantity.risk.name].definition,
        scenario=quantity.scenario,
        unit=quantity.metric.unit,
        kind="objective" if limit is None else "constraint",
        limit=None if limit is None else limit.most,
        default=default,
        tuned=tuned,
        difference=Estimate(*difference),
        verdict=verdict,
        automatic="" if limit is None else limit.floor,
    )


def compare_known(problem: Evaluator, gains: np.ndarray) -> list[RequiredRow]:
    """Compare the second of two gains rows (2, gains) with the first by requirement.

    Each requirement is compared in its worst state.
    """
    default, tuned = known_values(problem.screens, gains, complete=True)
    states = [worst_states(problem.screens, row) for row in gains]
    return [
        required_row(requirement, float(default[i]), float(tuned[i]), [of.get(requirement.label) for of in states])
        for i, requirement in enumerate(problem.requirements)
    ]


def required_row(
    requirement: Requirement, default: float, tuned: float, states: Sequence[WorstState | None] = (None, None)
) -> RequiredRow:
    """Return the line of a requirement in SI units: numbers without intervals, null where a value is infinite.

    states: those that default and tuned gains were judged in, None where there is one alone.
    """
    finite = isfinite(default) and isfinite(tuned)
    first, second = (float(requirement.in_file(value)) for value in (default, tuned))
    row = RequiredRow(
        label=requirement.label,
        quantity=requirement.quantity,
        unit=requirement.unit,
        kind="requirement",
        limit=float(requirement.in_file(requirement.limit)),
        sense=requirement.sense,
        hard=requirement.hard,
        default=known_value(first),
        tuned=known_value(second),
        difference=known_value(second - first if finite else None),
        verdict=SATISFIED if requirement.is_satisfied(np.array([tuned]))[0] else BROKEN,
    )
    row = row.model_copy(update=requirement.units())
    before, after = states
    if before is None or after is None:
        return row
    each = compared_states(requirement, before, after)
    return row.model_copy(update={"default_state": before.name, "tuned_state": after.name, "states": each})


def compared_states(requirement: Requirement, before: WorstState, after: WorstState) -> list[ComparedState]:
    """Return a requirement by steady state, in SI units."""
    columns = [requirement.in_file(one.values).tolist() for one in (before, after)]
    return [
        ComparedState(
            state=name, default=first if isfinite(first) else None, tuned=second if isfinite(second) else None
        )
        for name, first, second in zip(before.states, *columns, strict=True)
    ]


def known_value(value: float | None) -> Estimate:
    """Return a number without an interval; null where it is infinite."""
    return Estimate(value if value is not None and isfinite(value) else None, None, None)
