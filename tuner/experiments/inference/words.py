"""An inference in sentences: which cells are reproduced, by one setting and by any, and which unknowns the cells tell."""

from collections.abc import Iterable
from math import exp, isclose

from tuner.documents.inference_document import (
    CellRow,
    InferenceDocument,
    KindRow,
    MisfitPart,
    MissedCell,
    RatioRow,
    UnknownRow,
)
from tuner.text.numbers import per_cent, significant
from tuner.text.sentences import listing
from tuner.text.units import after_number


def sentences(document: InferenceDocument) -> list[str]:
    """Return an inference in sentences, from the content of inference.json."""
    return [
        *misfit_words(document),
        *cell_words(document),
        *ratio_words(document),
        *unknown_words(document),
        *failure_words(document),
    ]


def misfit_words(document: InferenceDocument) -> Iterable[str]:
    """Yield sentences on the misfit at the inferred setting and the default."""
    cells, misfit = document.cells, document.misfit
    yield (
        f"At the inferred setting {misfit.inferred.inside} of {len(cells)} published cells lie in the central 95 % of "
        f"{document.settings.held_out} held-out flights; at the default {misfit.default.inside}."
    )
    parts = [
        f"{kind.metric} {_factor(misfit.inferred, kind)} (default {_factor(misfit.default, kind)})"
        for kind in document.kinds
    ]
    yield f"Our medians miss the published cells typically by a factor of: {listing(parts)}."


def cell_words(document: InferenceDocument) -> Iterable[str]:
    """Yield sentences on the reproduced and the missed cells."""
    cells, tried = document.cells, document.settings.tried
    never = [cell for cell in cells if not cell.reproducible]
    if never:
        yield f"Reproduced by none of {tried} settings: {listing(_missed(cell) for cell in never)}."
    else:
        yield f"Every published cell is reproduced by at least one of {tried} settings."
    elsewhere = [cell for cell in cells if cell.reproducible and not cell.consistent]
    if elsewhere:
        share = per_cent(document.settings.near)
        names = listing(_missed(cell) for cell in elsewhere)
        yield f"Reproduced only by settings that miss the rest by more than {share} above the least misfit: {names}."
    together = document.together
    held_out = f"held out it reproduces {together.held_out}"
    if together.missed:
        held_out += f", all but {listing(_name(cell) for cell in together.missed)}"
    yield (
        f"The most that one setting of the search reproduces at once are {together.search} of {together.of} "
        f"({together.candidate}); {held_out}."
    )


def ratio_words(document: InferenceDocument) -> Iterable[str]:
    """Yield sentences on the published ratios between contenders in the same air."""
    ratios = document.ratios
    if not ratios:
        return
    inside = document.misfit.inferred.ratios_inside
    yield (
        f"Of {len(ratios)} published ratios between contenders in the same air, {inside} are reproduced at the inferred "
        "setting."
    )
    missed = [ratio for ratio in ratios if not ratio.consistent]
    if missed:
        yield f"Ratios that no setting near the least misfit reproduces: {listing(_missed_ratio(ratio) for ratio in missed)}."


def unknown_words(document: InferenceDocument) -> Iterable[str]:
    """Yield a sentence on the identifiability of each unknown."""
    share = per_cent(document.settings.near)
    for row in document.unknowns:
        near, repeated = (_span(row, *ends) for ends in (row.near, row.resampled))
        inferred = significant(row.inferred, 3) + after_number(row.unit)
        verdict = {
            "told": f"is told by the cells: {inferred}",
            "loosely": f"is told loosely: {inferred}",
            "not": f"is not told by the cells; {inferred} is as good as others",
        }[row.verdict]
        if row.verdict != "not" and any(isclose(row.inferred, end) for end in (row.low, row.high)):
            verdict = f"stands at an end of the range searched, {inferred}, and a wider range may fit better"
        end = ", which reaches an end of the range searched" if row.at_end else ""
        yield (
            f"{row.name} {verdict}. Within {share} of the least misfit: {near}{end}; the table, being one draw, leaves "
            f"{repeated} (68 %)."
        )


def failure_words(document: InferenceDocument) -> Iterable[str]:
    """Yield sentences on the contenders whose flights fail."""
    for row in document.failures:
        if row.inferred > 0.0:
            yield f"{row.contender} loses {per_cent(row.inferred)} of its flights at the inferred setting."


def _factor(misfit: MisfitPart, kind: KindRow) -> str:
    return significant(exp(misfit.held_out[kind.metric]), 3)


def _missed(cell: CellRow) -> str:
    ours = cell.ours
    return (
        f"{_name(cell)} (published {significant(cell.published, 3)} {cell.unit}, 95 % of ours "
        f"{significant(ours.low95, 3)} to {significant(ours.high95, 3)})"
    )


def _name(cell: CellRow | MissedCell) -> str:
    return f"{cell.metric} of {cell.contender}"


def _missed_ratio(ratio: RatioRow) -> str:
    ours = ratio.ours
    return (
        f"{ratio.metric} {ratio.second} to {ratio.first} (published {significant(ratio.published, 3)}, 95 % of ours "
        f"{significant(ours.low95, 3)} to {significant(ours.high95, 3)})"
    )


def _span(row: UnknownRow, low: float, high: float) -> str:
    return f"{significant(low, 3)} to {significant(high, 3)}{after_number(row.unit)}"
