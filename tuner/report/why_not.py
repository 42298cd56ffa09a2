"""Reasons against a finalist in words: which limit it violates, or what it loses to the recommended point."""

from math import inf

from tuner.documents.parts import on_page
from tuner.documents.summary import TableRow
from tuner.documents.tuning import SHOWN, TuningFolder
from tuner.documents.verdicts import BROKEN, verdict_on_limit
from tuner.report.labels import in_plain_words, named, names_of
from tuner.text.numbers import per_cent, significant
from tuner.text.sentences import bound_text, capitalized, counted, listing
from tuner.text.units import plain

MAX_LIMITS = 3
"""Limits named in a sentence."""


def why_not(results: TuningFolder, row: int) -> str:
    """Return the reason against a point by its row of the front.

    Of the recommended point it is the reason of the pick. All values are held out.
    """
    violated = _violated(results, row)
    if results.held_out_front.points[row] == results.tuned:
        role = "Recommended" if results.feasible else "Nearest to feasible"
        reason = in_plain_words(results.document.pick.why.strip().rstrip("."), names_of(results))
        reason = reason.replace("flights", results.sample_noun)
        return " ".join(filter(None, [f"{role}: {reason}.", violated]))
    return f"Why not this point: {violated or _uncertain(results, row) or _compared(results, row)}"


def _violated(results: TuningFolder, row: int) -> str:
    """Return the limits that a point violates: the most violated first."""
    limits = [entry for entry in results.rows_of(row) if entry.limit is not None]
    shown = [on_page(entry, *SHOWN) for entry in limits if entry.verdict == BROKEN]
    if not shown:
        return ""
    worst = sorted(shown, key=lambda entry: -_beyond(entry) / (abs(entry.limit or 0.0) or 1.0))
    texts = [_violation(results, entry) for entry in worst[:MAX_LIMITS]]
    more = [f"{len(worst) - MAX_LIMITS} more"] if len(worst) > MAX_LIMITS else []
    return capitalized(f"it violates {counted(len(worst), 'limit')}: {listing([*texts, *more])}")


def _beyond(entry: TableRow) -> float:
    """Return the distance of a value beyond its limit: null is infinite."""
    return inf if entry.tuned.value is None else abs(entry.tuned.value - (entry.limit or 0.0))


def _violation(results: TuningFolder, entry: TableRow) -> str:
    """Return "phase margin 32.1 ° (min 35, 2.9 too low)"."""
    value = "infinite" if entry.tuned.value is None else significant(entry.tuned.value)
    side = "low" if entry.sense == "min" else "high"
    excess = "" if entry.tuned.value is None else f", {significant(_beyond(entry), 3)} too {side}"
    bound = bound_text(entry.limit or 0.0, entry.sense)
    return f"{named(results, entry, short=True)} {_with_unit(value, entry.unit)} ({bound}{excess})"


def _uncertain(results: TuningFolder, row: int) -> str:
    """Return the limits within the intervals of an infeasible point."""
    if results.held_out_front.feasible[row]:
        return ""
    shown = [on_page(entry, *SHOWN) for entry in results.rows_of(row) if entry.kind == "constraint"]
    over = [entry for entry in shown if verdict_on_limit(entry.tuned.high, entry.limit or 0.0) == BROKEN]
    texts = [
        f"{named(results, entry, short=True)} up to {_with_unit(significant(entry.tuned.high), entry.unit)} "
        f"({bound_text(entry.limit or 0.0)})"
        for entry in over
    ]
    return capitalized(f"its intervals reach beyond a limit{': ' if texts else ''}{listing(texts)}")


def _compared(results: TuningFolder, row: int) -> str:
    """Return the objectives in which a point is worse, and better."""
    front = results.held_out_front
    at = front.points.index(results.tuned)
    changes = (front.held_out[row] - front.held_out[at]).tolist()
    texts: dict[bool, list[str]] = {True: [], False: []}
    for i, (objective, change) in enumerate(zip(results.objectives, changes, strict=True)):
        are_separate = front.low[row, i] > front.high[at, i] or front.high[row, i] < front.low[at, i]
        share = [per_cent(abs(change / front.held_out[at, i]))] if front.held_out[at, i] else []
        notes = ", ".join([*share, *([] if are_separate else ["intervals overlap"])])
        size = _with_unit(significant(abs(change), 3), objective.unit)
        texts[change > 0.0].append(f"{size}{f' ({notes})' if notes else ''} in {named(results, objective, short=True)}")
    sides = [
        f"{word} by {listing(of_side)}"
        for word, of_side in (("worse", texts[True]), ("better", texts[False]))
        if of_side
    ]
    ending = "" if texts[True] else f"; the rule {results.document.pick.rule} picked the others"
    return f"Against the {results.shown_name}, by held-out values, it is {' and '.join(sides)}{ending}."


def _with_unit(number: str, unit: str) -> str:
    return f"{number} {plain(unit)}".rstrip()
