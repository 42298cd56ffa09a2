"""Sentences on rungs, printed numbers and claims, each made from numbers."""

from collections.abc import Iterable

from tuner.documents.comparison_document import ClaimRow, PublishedRow, RungRow
from tuner.experiments.compare.words import closing_words, finding_words
from tuner.extensions.contests.judging import FAILS, SURVIVES, UNDECIDED, ContestResult
from tuner.extensions.contests.race import LEAD
from tuner.text.numbers import count, per_cent
from tuner.text.sentences import listing


def contest_sentences(result: ContestResult) -> list[str]:
    """Return the sentences on a contest's result."""
    return [
        *rung_words(result),
        *finding_words(result),
        *published_words(result),
        *claim_words(result),
        *closing_words(result),
    ]


def rung_words(result: ContestResult) -> Iterable[str]:
    """Say which searches went on from each rung, and what that saved."""
    numbers = sorted({row.rung for row in result.rungs})
    for number in numbers:
        rows = [row for row in result.rungs if row.rung == number]
        on, stopped = (listing(_standing(row) for row in rows if row.goes_on is goes_on) for goes_on in (True, False))
        yield f"Rung {number}, {max(row.generations for row in rows)} generations: {on} went on; stopped: {stopped}."
    planned = result.study.halving.finalists if result.study.halving else 0
    if numbers and len(result.names) < planned:
        compared = "one finalist is" if len(result.names) == 1 else f"{len(result.names)} finalists are"
        yield (
            f"Of {planned} finalists {compared} compared: the others have nothing within the limits, or are behind by more than "
            f"{per_cent(LEAD)} in every objective, so a comparison would decide nothing."
        )
    if numbers:
        searches = sum(entrant.search_flights for entrant in result.prepared)
        dropped = sum(row.flights for row in result.rungs if not row.goes_on)
        every = len({row.contender for row in result.rungs})
        yield (
            f"Successive halving made {count(searches + dropped)} search flights for {every} contenders; the searches that were "
            f"carried to their end made {count(searches)}. Shares are of the common box of a rung's fronts on search flights."
        )


def _standing(row: RungRow) -> str:
    """Return a contender with its share of the common box."""
    return f"{row.contender} ({f'{row.share:.2f}' if row.feasible else 'nothing feasible'})"


def published_words(result: ContestResult) -> Iterable[str]:
    """Count the printed numbers inside our distribution over seeds; in all and for each contender."""
    free = [cell for cell in result.published if not cell.fitted]
    fitted = [cell for cell in result.published if cell.fitted]
    if free:
        yield (
            f"Of {len(free)} comparisons with printed numbers, {_inside(free)} lie between the 2.5 and the 97.5 percentile of "
            f"our flights: {listing(_per_contender(result, free))}."
        )
    if fitted:
        yield (
            f"Of {len(fitted)} more with numbers that the study was set to meet, {_inside(fitted)} lie there: "
            f"{listing(_per_contender(result, fitted))}."
        )


def _per_contender(result: ContestResult, cells: list[PublishedRow]) -> Iterable[str]:
    for name in result.names:
        mine = [cell for cell in cells if cell.contender == name]
        if mine:
            yield f"{name} {_inside(mine)} of {len(mine)}"


def _inside(cells: list[PublishedRow]) -> int:
    return sum(cell.inside for cell in cells)


def claim_words(result: ContestResult) -> Iterable[str]:
    """Say which claims hold."""
    for judged in result.claims:
        basis = f" {judged.basis}" if judged.basis else ""
        yield f'The claim "{judged.text}" {_VERDICT[judged.verdict]}{basis}: {_counted(judged)}.'


_VERDICT = {SURVIVES: "survives", FAILS: "fails", UNDECIDED: "is undecided"}


def _counted(judged: ClaimRow) -> str:
    verdicts = [ruling.verdict for ruling in judged.rows]
    kinds = ((SURVIVES, "for it"), (FAILS, "against it"), (UNDECIDED, "without a decision"))
    counts = [f"{verdicts.count(kind)} {words}" for kind, words in kinds if kind in verdicts]
    return f"of {len(verdicts)} paired comparisons {listing(counts)}"
