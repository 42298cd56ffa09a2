"""Warnings that need the results of a run. Each function takes plain numbers and returns sentences, none where all is well."""

from collections.abc import Collection, Mapping, Sequence
from itertools import combinations
from statistics import mean

import numpy as np

from objectives.risk.differences import BETTER, WORSE, classify_difference
from plant.ties import mean_ranks
from tuner.documents.comparison_document import BoundRow
from tuner.documents.parts import row_in_degrees
from tuner.documents.summary import ComparedRow
from tuner.experiments.tuning.flight_growth import MAX_RATIO, value_ratios
from tuner.search.convergence import (
    QUARTER,
    TOLERANCE,
    generations_to_convergence,
    last_quarter,
    last_quarter_improvement,
)
from tuner.text.numbers import significant
from tuner.text.sentences import first_texts, listing
from tuner.text.units import after_number

Times = Sequence[float]
# Objectives that differ by less than this share of their size are constant; rank correlations from here on are perfect.
SAME, PERFECT = 1e-9, 0.999
# Candidates from which on a perfect correlation is no accident: ten ranks agree by chance once in 3.6 million.
ENOUGH = 10
# Share of all candidates from which on those that do not fly the mission are told of.
MANY = 0.5
# Share of the time left from which on a mean time says that most flights came to no event.
SELDOM = 0.9
NO_EVENT = "Make the flights longer or the band wider, or judge by an error instead of a time."
# Rise over the default's value, as a share of it, from which on a warning names a quantity that nothing judges.
MUCH = 0.5


def constant_objectives(labels: Sequence[str], values: np.ndarray, never: Sequence[Times]) -> list[str]:
    """Warn of objectives whose values (n, objectives) are the same for all candidates flown.

    never: for each objective the times [s] that represent an event that a flight did not come to, by scenario.
    """
    if len(values) < 2:
        return []
    spread, size = np.ptp(values, axis=0), np.abs(values).max(axis=0)
    return [
        f"{label} is the same for all {len(values)} candidates flown: {_why_constant(float(value), times)}"
        for label, value, wide, large, times in zip(labels, values[0], spread, size, never, strict=True)
        if wide <= SAME * large
    ]


def _why_constant(value: float, never: Times) -> str:
    if never and min(never) * (1.0 - SAME) <= value <= max(never) * (1.0 + SAME):
        return f"{value:.4g} s, the time left in a flight, because no flight comes to what it waits for. {NO_EVENT}"
    return "no gain that is searched moves it. Leave it out, or search a gain that does."


def seldom_reached(labels: Sequence[str], values: Sequence[float | None], never: Sequence[Times]) -> list[str]:
    """Warn of mean times near that of a flight without the event.

    Args:
        labels: Labels of the objectives.
        values: Values on confirmation flights.
        never: Times [s] that a flight without the event counts as, by objective and scenario.
    """
    return [
        f"{label} is {value:.4g} s, and {mean(times):.4g} s is the value of a flight without the event: most "
        f"flights have none. {NO_EVENT}"
        for label, value, times in zip(labels, values, never, strict=True)
        if times and value is not None and value >= SELDOM * mean(times)
    ]


def correlated_objectives(labels: Sequence[str], values: np.ndarray) -> list[str]:
    """Warn of pairs of objectives that rank all candidates flown alike; values (n, objectives)."""
    if len(values) < ENOUGH:
        return []
    ranks = np.stack([mean_ranks(column) for column in values.T], axis=1)
    ranks -= ranks.mean(axis=0)
    length = np.sqrt(np.square(ranks).sum(axis=0))
    return [
        f"{labels[i]} and {labels[j]} rank all {len(values)} candidates flown alike, so there is nothing to trade between "
        f"them. Leave one out."
        for i, j in combinations(range(len(labels)), 2)
        if length[i] > 0.0 and length[j] > 0.0 and ranks[:, i] @ ranks[:, j] >= PERFECT * length[i] * length[j]
    ]


def duplicate_knees(names: Sequence[str], tuned: int, words: Mapping[int, Collection[str]]) -> list[str]:
    """Warn of points neither better nor worse than the recommended one.

    Args:
        names: Names of all finalists.
        tuned: Row of the recommended one.
        words: Row on the front -> words on its differences to the recommended one.
    """
    alike = [names[row] for row, each in words.items() if row != tuned and not {BETTER, WORSE} & set(each)]
    if not alike:
        return []
    others = first_texts(alike, 3)
    return [
        f"The tuned gains ({names[tuned]}) are neither better nor worse than {others} in any objective. Take any of them, or "
        "raise held_out."
    ]


def lost_flights(lost: int, flights: int, limited: bool) -> list[str]:
    """Warn of confirmation flights that the recommended point lost; where no limit forbids it."""
    if lost == 0 or limited:
        return []
    return [
        f"The recommended point failed {lost} of {flights} confirmation flights, and no limit forbids it; failed flights "
        'dominate means. Add [[constraint]] metric = "failure", max = 0.0.'
    ]


def gains_on_bounds(bounds: Sequence[BoundRow]) -> list[str]:
    """Warn of recommended gains at a movable end of their range."""
    return [
        f"{entry.variable} = {entry.value:.4g} is at the {entry.end} end of its range, {entry.bound:.4g}"
        + (f", as in {100.0 * entry.share:.0f} % of the front" if entry.share > 0.0 else "")
        + ". Widen the range there if the vehicle allows."
        for entry in bounds
        if entry.recommended and not entry.natural
    ]


def lenient_flights(
    labels: Sequence[str],
    search: np.ndarray,
    held_out: np.ndarray,
    flights: Sequence[int],
    resumable: bool = True,
) -> list[str]:
    """Warn of objectives that held-out flights do not confirm.

    Args:
        labels: Labels of the objectives.
        search: Values (n, objectives) of the front on the flights of the search.
        held_out: Values (n, objectives) of the front on held-out flights.
        flights: Numbers of flights of a candidate in the search, one a scenario.
        resumable: Whether the run can go on with more of them.
    """
    warnings = []
    more = 2 * max(flights)
    advice = (
        f"Continue: `tuner resume` with --search-flights {more}."
        if resumable
        else f"Raise search, the flights of each scenario, to {more} and run again."
    )
    for label, column in zip(labels, value_ratios(search, held_out).T, strict=True):
        ratios = column[~np.isnan(column)]
        if len(ratios) and (ratio := float(np.median(ratios))) > MAX_RATIO:
            warnings.append(
                f"{label} is {ratio:.2f} times as large on the held-out flights as on the {sum(flights)} of the search, in the "
                f"median of the front: these flights were lenient, and more generations on them help little. {advice}"
            )
    return warnings


def worse_unjudged(rows: Sequence[ComparedRow]) -> list[str]:
    """Warn of quantities without a judge that became much worse.

    rows: Quantities that an automatic limit alone holds.
    """
    texts = []
    for row in rows:
        numbers = [row.default.value, *row.difference.parts]
        present = [number for number in numbers if number is not None]
        if len(present) < len(numbers) or classify_difference(*present, relevant=MUCH) != WORSE:
            continue
        shown = row_in_degrees(row, "default", "tuned")
        add = f'metric = "{row.metric}"' + (f', scenario = "{row.scenario}"' if row.scenario else "")
        texts.append(
            f"{row.label} rises from {significant(shown.default.value, 3)} to {significant(shown.tuned.value, 3)}"
            f"{after_number(shown.unit)}: no objective and no limit of the study judges it, only an automatic limit does. "
            f"Add for instance [[objective]] {add}."
        )
    return texts


def unlimited_margins(broken: Sequence[str]) -> list[str]:
    """Warn of broken usual margins in a study that limits none.

    broken: Limits in words, "gain_up 5.66 dB (usual min 6)".
    """
    if not broken:
        return []
    return [
        f"No [[margin]] limits the loops, and the recommended gains break usual limits: {listing(broken)}. Add for instance "
        '[[margin]] quantity = "ms", max = 2.'
    ]


def still_rising(volumes: Sequence[float], flights: Sequence[int], resumable: bool = True) -> list[str]:
    """Warn where a search has not converged, and estimate the budget.

    Args:
        volumes: Hypervolume so far, one a generation.
        flights: Number of flights so far, one a generation.
        resumable: Whether the run can go on with a larger budget.
    """
    done, share = len(volumes), last_quarter_improvement(volumes)
    # Of fewer than four generations the last one is more than a quarter.
    if share <= TOLERANCE * max(last_quarter(done) / (QUARTER * done), 1.0):
        return []
    budget = generations_to_convergence(volumes)
    if budget is None:
        budget = 2 * done
        advice = " How many it needs cannot be estimated."
    else:
        each = (flights[-1] - flights[-1 - last_quarter(done)]) / last_quarter(done)
        total = float(f"{flights[-1] + each * (budget - done):.2g}")
        advice = f" Expected to converge after about {budget} generations ({total:,.0f} flights)."
    return [
        f"The search has not converged: {100.0 * share:.0f} % of the hypervolume came in the last {last_quarter(done)} of "
        f"{done} generations.{advice} {_continuation(budget, resumable)}"
    ]


def _continuation(budget: int, resumable: bool) -> str:
    if not resumable:
        return f"Ask again with search.generations = {budget} and another --out."
    return f"Continue: `tuner resume` with --budget {budget}."


def idle_candidates(idle: int, tried: int) -> list[str]:
    """Warn where most candidates satisfied all but the automatic limits on tracking."""
    if idle <= MANY * tried:
        return []
    return [f"{idle} of {tried} candidates satisfied every limit except tracking and count as infeasible."]
