"""Terms of control laws that a search turned off: gains that ended at 0, in sentences."""

from plant.law_registry import LAWS
from plant.quadrotor.cascade import POSITION_AXES
from tuner.documents.summary import VariableRow
from tuner.documents.tuning import DEFAULT, TuningFolder
from tuner.report.words import laws_of
from tuner.text.numbers import significant

ZERO_SHARE = 1e-6
"""Share of the upper end of a range below which a gain is 0."""


def off_terms_text(results: TuningFolder) -> str:
    """Return a sentence for each term that the search turned off; "" without any."""
    if results.document.shown == DEFAULT or results.is_external:
        return ""
    texts = [
        f" The search turned the {term} of {row.name.partition('.')[0]} off: {row.name} = 0 (default "
        f"{significant(row.default, 3)})."
        for row in results.variables
        if is_turned_off(row)
        for term in terms_of(results, row)
    ]
    return "".join(texts)


def is_turned_off(row: VariableRow) -> bool:
    """Return True for a gain at 0 whose default is not."""
    least = ZERO_SHARE * row.high
    return abs(row.tuned) <= least < abs(row.default)


def terms_of(results: TuningFolder, row: VariableRow) -> list[str]:
    """Return the names of the terms that a gain turns off."""
    laws = {loop: law for law, loop in laws_of(results.resolved)}
    terms = list[str]()
    for address in results.addresses[row.name]:
        axis, _, gain = address.partition(".")
        name = laws.get(axis) or laws.get("position" if axis in POSITION_AXES else "attitude", "")
        gains = LAWS[name].gains if name in LAWS else ()
        terms += [info.term for info in gains if info.term and info.name.rstrip("_") == gain]
    return list(dict.fromkeys(terms))
