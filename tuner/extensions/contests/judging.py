"""Printed numbers and claims of a paper against the flights.

A claim survives where every difference behind it is "better". A printed number is "inside" where it lies in the central 95 % of
the distribution over seeds that the same experiment has here.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from objectives.risk.differences import BETTER, WORSE
from tuner.documents.comparison_document import ClaimRow, PublishedRow, RulingRow, RungRow
from tuner.documents.parts import SampledValue
from tuner.experiments.compare.flying import Flown
from tuner.experiments.compare.result import Result
from tuner.experiments.compare.statistics import Comparison
from tuner.extensions.contests.study import Claim, Contest, Published
from tuner.text.numbers import per_cent
from tuner.text.sentences import listing

SURVIVES, FAILS, UNDECIDED = "survives", "fails", "undecided"
# A printed number is "inside" where it lies between these percentiles of the flights.
INSIDE = (2.5, 97.5)
# Share from which on another objective is told beside a claim; quantities of a claim that are listed at most.
LARGE, MAX_LABELS = 0.2, 3


@dataclass(frozen=True)
class ContestResult(Result):
    """A contest with its results; rungs: contenders of every rung, empty without halving."""

    study: Contest
    rungs: list[RungRow] = field(default_factory=list)

    @cached_property
    def published(self) -> list[PublishedRow]:
        """The printed numbers, each judged."""
        return judge_published(self.study, self.flown, self.comparison)

    @cached_property
    def claims(self) -> list[ClaimRow]:
        """The claims, each judged."""
        return judge_claims(self.study, self.comparison, bool(self.fronts))


def judge_claims(contest: Contest, comparison: Comparison, is_tuned: bool = False) -> list[ClaimRow]:
    """Judge every claim of a contest: opponents in turn, quantities within.

    is_tuned: whether a search found the points compared.
    """
    labels = [quantity.label for quantity in contest.quantities]
    names = [contender.name for contender in contest.contenders]
    judged = []
    for claim in contest.claims:
        better, rows = names.index(claim.better), []
        for name in claim.than:
            for objective in claim.objectives:
                place = (better, names.index(name), labels.index(objective.label))
                rows.append(ruling(name, objective.label, comparison.difference(*place), comparison.word(*place)))
        basis = claim_basis(claim, other_differences(contest, comparison, claim), is_tuned)
        judged.append(judged_claim(claim, rows, basis))
    return judged


def other_differences(contest: Contest, comparison: Comparison, claim: Claim) -> dict[str, float]:
    """Return the shares by which other objectives of a claim's contenders differ; those above `LARGE`.

    A share is of the larger value, and the largest of all opponents.
    """
    names = [contender.name for contender in contest.contenders]
    claimed = {objective.label for objective in claim.objectives}
    better, differing = comparison.estimates[names.index(claim.better)], dict[str, float]()
    for i, quantity in enumerate(contest.quantities):
        if quantity.kind != "objective" or quantity.label in claimed:
            continue
        pairs = [(better[i].value, comparison.estimates[names.index(name)][i].value) for name in claim.than]
        share = max(abs(one - other) / (max(abs(one), abs(other)) or 1.0) for one, other in pairs)
        if share > LARGE:
            differing[quantity.label] = share
    return differing


def claim_basis(claim: Claim, differing: Mapping[str, float], is_tuned: bool) -> str:
    """Return the quantities of a claim, and other objectives that differ."""
    labels = [objective.label for objective in claim.objectives]
    text = f"in {listing(labels)}" if len(labels) <= MAX_LABELS else f"in {len(labels)} quantities"
    up_to = "" if len(claim.than) == 1 else "up to "
    if differing:
        return f"{text}, at points whose {listing(f'{name} differs by {up_to}{per_cent(s)}' for name, s in differing.items())}"
    return f"{text}, at the points compared" if is_tuned else text


def ruling(than: str, quantity: str, gap: SampledValue, word: str) -> RulingRow:
    """Return a claim for one opponent and quantity; gap: `better` minus opponent; word: on it, which decides."""
    verdict = {BETTER: SURVIVES, WORSE: FAILS}.get(word, UNDECIDED)
    return RulingRow(than=than, quantity=quantity, difference=gap.value, low=gap.low, high=gap.high, verdict=verdict)


def judged_claim(claim: Claim, rows: list[RulingRow], basis: str = "") -> ClaimRow:
    """Return a claim with its rulings: it survives if every one does, fails if any does, and is undecided otherwise."""
    verdicts = [row.verdict for row in rows]
    verdict = FAILS if FAILS in verdicts else UNDECIDED if UNDECIDED in verdicts else SURVIVES
    return ClaimRow(
        text=claim.text, basis=basis, better=claim.better, than=list(claim.than), verdict=verdict, rows=rows
    )


def judge_published(contest: Contest, flown: Flown, comparison: Comparison) -> list[PublishedRow]:
    """Judge every printed number for each of its contenders."""
    labels = [quantity.label for quantity in contest.quantities]
    names = [contender.name for contender in contest.contenders]
    rows = []
    for entry in contest.published:
        i = labels.index(entry.objective.label)
        for name in entry.contenders:
            k = names.index(name)
            rows.append(published_row(entry, name, comparison.estimates[k][i], flown.samples(i, entry.scenario)[k]))
    return rows


def published_row(entry: Published, contender: str, mean: SampledValue, values: np.ndarray) -> PublishedRow:
    """Return the row of a printed number and a contender's flights; values (n,), mean: of these, with its interval."""
    low, median, high = np.quantile(values, [INSIDE[0] / 100.0, 0.5, INSIDE[1] / 100.0], axis=-1).tolist()
    percentile = percentile_of(entry.value, values)
    return PublishedRow(
        contender=contender,
        contenders=list(entry.contenders),
        metric=entry.metric.text,
        unit=entry.metric.unit,
        scenario=entry.scenario,
        quantity=entry.objective.label,
        value=entry.value,
        source=entry.source,
        fitted=entry.fitted,
        mean=mean.value,
        low=mean.low,
        high=mean.high,
        p2_5=low,
        median=median,
        p97_5=high,
        percentile=float(percentile),
        inside=bool(is_inside(percentile)),
    )


def percentile_of(value: float | np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the percentile (...) of value (...) among values (..., n): 100 times the share below, ties counted half."""
    printed = np.asarray(value)[..., None]
    return 100.0 * (np.mean(values < printed, axis=-1) + 0.5 * np.mean(values == printed, axis=-1))


def is_inside(percentiles: np.ndarray) -> np.ndarray:
    """Return True for printed values in the central 95 % of flights."""
    return (percentiles >= INSIDE[0]) & (percentiles <= INSIDE[1])
