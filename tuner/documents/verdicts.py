"""Verdicts on quantities: the one place that decides which holds, and how files, terminal and page word it."""

from math import inf

from tuner.documents.parts import Estimate, SampledValue

BETTER, WORSE, NO_DIFFERENCE = "better", "worse", "no clear difference"
SATISFIED, NOT_CERTAIN, BROKEN = "kept", "not certain", "broken"
UNKNOWN = "not known"
# The same gains, decoded from a point of the unit cube, differ in the last digit.
SAME = 1e-9


SHOWN = {SATISFIED: "satisfied", BROKEN: "violated", NO_DIFFERENCE: "no significant difference"}
"""Verdict of files -> verdict of report and terminal, where they differ."""


def shown_verdict(verdict: str) -> str:
    """Return a verdict of files as report and terminal word it."""
    return SHOWN.get(verdict, verdict)


def verdict_on_difference(default: float, difference: Estimate | SampledValue) -> str:
    """Return the verdict that the interval of a difference to the default's value allows."""
    if difference.value is None or difference.low is None or difference.high is None:
        return UNKNOWN
    if abs(difference.value) <= SAME * abs(default):
        return NO_DIFFERENCE
    if difference.high < 0.0:
        return BETTER
    return WORSE if difference.low > 0.0 else NO_DIFFERENCE


def verdict_on_limit(value: float | None, limit: float, sense: str = "max", high: float | None = None) -> str:
    """Return the verdict on a value with a limit; null is infinite.

    high: upper end of the value's interval where that must not exceed a largest value either.
    """
    value = inf if value is None else value
    if not (value >= limit if sense == "min" else value <= limit):
        return BROKEN
    return SATISFIED if high is None or high <= limit else NOT_CERTAIN
