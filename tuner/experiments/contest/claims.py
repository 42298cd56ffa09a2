"""Claims against the differences: a claim survives where every interval lies on its side of zero."""

from dataclasses import dataclass

from tuner.documents.parts import SampledValue
from tuner.experiments.contest.comparison import Comparison
from tuner.study.contest import Claim, Contest

SURVIVES, FAILS, UNDECIDED = "survives", "fails", "undecided"


@dataclass(frozen=True)
class Ruling:
    """A claim for one opponent and one quantity, both by index; difference: `better` minus opponent."""

    than: int
    quantity: int
    difference: SampledValue

    @property
    def verdict(self) -> str:
        """Whether the interval lies below zero (survives), above it (fails) or holds it (undecided)."""
        if self.difference.high < 0.0:
            return SURVIVES
        return FAILS if self.difference.low > 0.0 else UNDECIDED


@dataclass(frozen=True)
class JudgedClaim:
    """A claim and its rulings, opponents in turn, quantities within."""

    claim: Claim
    better: int
    rulings: list[Ruling]

    @property
    def verdict(self) -> str:
        """Survives if every ruling does, fails if any does, and is undecided otherwise."""
        verdicts = [ruling.verdict for ruling in self.rulings]
        if FAILS in verdicts:
            return FAILS
        return UNDECIDED if UNDECIDED in verdicts else SURVIVES


def judge_claims(contest: Contest, comparison: Comparison) -> list[JudgedClaim]:
    """Judge every claim of a contest."""
    labels = [quantity.label for quantity in contest.quantities]
    names = [contender.name for contender in contest.contenders]
    judged = []
    for claim in contest.claims:
        better = names.index(claim.better)
        rulings = []
        for name in claim.than:
            for objective in claim.objectives:
                than, i = names.index(name), labels.index(objective.label)
                rulings.append(Ruling(than, i, comparison.difference(better, than, i)))
        judged.append(JudgedClaim(claim, better, rulings))
    return judged
