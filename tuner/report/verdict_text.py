"""The verdict on a tuning run in sentences: objectives against the default, limits, terms that the search turned off."""

from collections.abc import Sequence
from typing import Any

from objectives.risk.differences import WORDS
from tuner.documents.summary import ComparedRow, RequiredRow
from tuner.documents.tuning import DEFAULT, TuningFolder
from tuner.documents.verdicts import BROKEN, NOT_CERTAIN, UNKNOWN, verdict_on_limit
from tuner.report.labels import named
from tuner.report.off_terms import off_terms_text
from tuner.text.sentences import listing

PHRASES = {**{word: forms.phrase for word, forms in WORDS.items()}, UNKNOWN: "not comparable with {0} in {1}"}
"""Verdict on an objective -> phrase."""
ALL_LIMITS = {1: "the limit", 2: "both limits"}


def verdict_text(results: TuningFolder) -> str:
    """Return the verdict on the recommended or nearest point in sentences."""
    rows = [row for row in results.document.table if row.limit is not None]
    return _main_clause(results, _limits_text(results, rows)) + _uncertain_text(results, rows) + off_terms_text(results)


def _main_clause(results: TuningFolder, limits: str) -> str:
    if not results.feasible:
        return f"Nearest to feasible: {results.gains_noun} {results.tuned}. They {limits}."
    if results.tuned == DEFAULT:
        reason = results.document.pick.why
        return f"Keep the default {results.gains_noun}: {reason}{f'; they {limits}' if limits else ''}."
    phrases = _objective_phrases(results)
    joint = " and " if len(phrases) == 1 else "; they "
    return f"The {results.shown_name} are {'; '.join(phrases)}{joint + limits if limits else ''}."


def _objective_phrases(results: TuningFolder) -> list[str]:
    """Return a phrase for each verdict on objectives; the default is named in the first."""
    rows = [row for row in results.document.compared if row.kind == "objective"]
    phrases = list[str]()
    for verdict, phrase in PHRASES.items():
        names = [named(results, row, short=True) for row in rows if row.verdict == verdict]
        if names:
            text = phrase.format("the default", _all_or_names(names, len(rows)))
            phrases.append(
                text if not phrases else text.replace(" than the default", "").replace(" from the default", "")
            )
    return phrases


def _all_or_names(names: Sequence[str], count: int) -> str:
    if len(names) < count or count == 1:
        return listing(names)
    return "both objectives" if count == 2 else f"all {count} objectives"


def _limits_text(results: TuningFolder, limits: Sequence[ComparedRow | RequiredRow]) -> str:
    """Return "satisfy all 8 limits (the default violates 4)", or which it violates; "" without limits."""
    if not limits:
        return ""
    broken = [named(results, row, short=True) for row in limits if row.verdict == BROKEN]
    before = sum(is_violated(row, row.default.value) for row in limits)
    count = len(limits)
    text = (
        f"violate {len(broken)} of {count} limits: {listing(broken)}"
        if broken
        else f"satisfy {ALL_LIMITS.get(count, f'all {count} limits')}"
    )
    if results.document.shown != DEFAULT:
        text += f" (the default violates {before or 'none'})"
    return text


def _uncertain_text(results: TuningFolder, limits: Sequence[ComparedRow | RequiredRow]) -> str:
    """Return the sentence on limits within the interval; "" without any."""
    names = [named(results, row, short=True) for row in limits if row.verdict == NOT_CERTAIN]
    return f" Not certain within the interval: {listing(names)}." if names else ""


def is_violated(row: ComparedRow | RequiredRow, value: float | None) -> bool:
    """Return True for a value beyond the limit of its row; null is infinite."""
    return row.limit is not None and verdict_on_limit(value, row.limit, row.sense) == BROKEN


def beside_limit(value: float, row: Any, digits: int = 3) -> str:
    """Return a limited value, rounded without crossing its row's limit.

    digits: significant ones where they suffice.
    """
    verdict = is_violated(row, value)
    texts = [f"{value:.{count}g}" for count in (digits, 6, 9, 17)]
    return next(text for text in texts if is_violated(row, float(text)) == verdict)
