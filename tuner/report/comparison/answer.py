"""The answer of a comparison: who is better in which objective, and over the whole front."""

from collections.abc import Sequence

from objectives.risk.differences import WORDS
from tuner.documents.comparison import ComparedFolder
from tuner.documents.comparison_document import QuantityRow
from tuner.documents.parts import Estimate
from tuner.report.changes import relative_change
from tuner.report.labels import compared_label
from tuner.text.numbers import significant
from tuner.text.sentences import capitalized, listing

MAX_NAMES = 3
"""Contenders that a clause names; beyond, it counts them."""
Result = tuple[str, tuple[tuple[str, str], ...]]
"""Contender with the lowest value, and each other that it is not better than, with the word."""


def answer_text(compared: ComparedFolder) -> str:
    """Return the answer in sentences: objectives at the points compared, fronts, limits."""
    if len(compared.contenders) < 2:
        return ""
    return " ".join(filter(None, [_objectives_text(compared), _fronts_text(compared), _limits_text(compared)]))


def _objectives_text(compared: ComparedFolder) -> str:
    rows = [row for row in compared.shown.quantities if row.kind == "objective"]
    by_result: dict[Result | None, list[str]] = {}
    for row in rows:
        result = _result(compared, row)
        text = compared_label(compared, row.label)
        share = _share(compared, row, result) if result else ""
        by_result.setdefault(result, []).append(f"{text} ({share})" if share else text)
    clauses = [_clause(compared, result, texts) for result, texts in by_result.items()]
    return capitalized("; ".join(clauses)) if clauses else ""


def _result(compared: ComparedFolder, row: QuantityRow) -> Result | None:
    """Return the lowest contender of a quantity with its equals: None without any."""
    best, words = compared.best(row.label), compared.words_beside_best(row.label)
    if not best:
        return None
    first = next(name for name in compared.index if name in best)
    return first, tuple((name, words[name]) for name in compared.index if name in words)


def _clause(compared: ComparedFolder, result: Result | None, objectives: Sequence[str]) -> str:
    if result is None:
        return f"no difference in {listing(objectives)}"
    lowest, even = result
    others = [name for name in compared.index if name != lowest]
    if not even:
        worse = listing(others) if len(others) <= MAX_NAMES else f"all {len(others)} others"
        return f"{lowest} is better than {worse} in {listing(objectives)}"
    levels = [
        forms.phrase.format(listing(names), "")
        for word, forms in WORDS.items()
        if (names := [name for name, other in even if other == word])
    ]
    return f"{lowest} is lowest in {listing(objectives)}, {listing(text.removesuffix(' in ') for text in levels)}"


def _share(compared: ComparedFolder, row: QuantityRow, result: Result) -> str:
    """Return the difference of two contenders in per cent, or ""."""
    pairs = [entry for entry in compared.shown.differences if entry.quantity == row.label]
    if len(compared.contenders) != 2 or len(pairs) != 1:
        return ""
    entry, lowest = pairs[0], result[0]
    higher = entry.first if lowest == entry.second else entry.second
    value = compared.estimates.get((higher, row.label))
    change = entry.estimate
    if lowest == entry.first:
        change = Estimate(-entry.difference, -entry.high, -entry.low)
    relative = None if value is None else relative_change(value, change)
    return " ".join(relative) if relative else ""


def _fronts_text(compared: ComparedFolder) -> str:
    """Return the front with the largest hypervolume in a sentence."""
    fronts = compared.fronts
    if fronts is None or len(fronts.hypervolume) < 2 or len(fronts.objectives) < 2:
        return ""
    rows = sorted(fronts.hypervolume, key=lambda row: -row.value)
    even = [row.contender for row in rows[1:] if row.contender in fronts.even_with(rows[0].contender)]
    shares = f"{significant(rows[0].value, 3)} against {listing(significant(row.value, 3) for row in rows[1:])}"
    most = f"Over the whole front {rows[0].contender} dominates"
    if even:
        return f"{most} the most of the objective space ({shares}), with no difference shown to {listing(even)}."
    return f"{most} more of the objective space ({shares})."


def _limits_text(compared: ComparedFolder) -> str:
    """Return the limits that contenders violate at the points compared."""
    limited = [row for row in compared.shown.quantities if row.limit is not None]
    by_limits: dict[str, list[str]] = {}
    for name in compared.index:
        values = [(row, compared.estimates.get((name, row.label))) for row in limited]
        violated = [
            compared_label(compared, row.label)
            for row, entry in values
            if row.limit is not None and entry is not None and entry.value is not None and entry.value > row.limit
        ]
        if violated:
            by_limits.setdefault(listing(violated), []).append(name)
    if by_limits:
        clauses = [
            f"{listing(names)} {'violates' if len(names) == 1 else 'violate'} the limit on {text}"
            for text, names in by_limits.items()
        ]
        return capitalized("; ".join(clauses))
    return "Every limit is satisfied." if limited else ""
