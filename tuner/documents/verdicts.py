"""Verdicts on quantities: which holds, and how files, terminal and page word it.

The rule for differences is in `objectives.risk.differences`.
"""

from math import inf
from typing import Annotated

from pydantic import BeforeValidator

from objectives.risk import RELEVANT, classify_difference
from objectives.risk.differences import NOT_DISTINGUISHABLE, WORDS
from tuner.documents.parts import Estimate, SampledValue

SATISFIED, NOT_CERTAIN, BROKEN = "kept", "not certain", "broken"
UNKNOWN = "not known"
SHOWN = {SATISFIED: "satisfied", BROKEN: "violated"}
"""Verdict of files -> verdict of report and terminal, where they differ."""
SIGNS = {
    **{word: forms.sign for word, forms in WORDS.items()},
    SATISFIED: "✓", NOT_CERTAIN: "≈", BROKEN: "✗",
}  # fmt: skip
"""Verdict of files -> sign next to it, for the quick eye; color is never the only sign."""
FORMER = {"no clear difference": NOT_DISTINGUISHABLE}
"""Verdict of files of earlier versions -> verdict of today."""


def _renamed(word: object) -> object:
    return FORMER.get(word, word) if isinstance(word, str) else word


Verdict = Annotated[str, BeforeValidator(_renamed)]
"""Verdict in a file; those of earlier versions are read."""


def shown_verdict(verdict: str) -> str:
    """Return a verdict of files as report and terminal word it."""
    return SHOWN.get(verdict, verdict)


def signed_verdict(verdict: str) -> str:
    """Return a verdict as the page words it, behind its sign."""
    return f"{SIGNS.get(verdict, '')} {shown_verdict(verdict)}".strip()


def verdict_on_difference(
    reference: float | None, difference: Estimate | SampledValue, relevant: float = RELEVANT
) -> str:
    """Return the verdict on a difference to a reference's value; null is not known."""
    value, low, high = difference
    if reference is None or value is None or low is None or high is None:
        return UNKNOWN
    return classify_difference(reference, value, low, high, relevant)


def verdict_on_limit(value: float | None, limit: float, sense: str = "max", high: float | None = None) -> str:
    """Return the verdict on a value with a limit; null is infinite.

    high: upper end of the value's interval where that must not exceed a largest value either.
    """
    value = inf if value is None else value
    if not (value >= limit if sense == "min" else value <= limit):
        return BROKEN
    return SATISFIED if high is None or high <= limit else NOT_CERTAIN
