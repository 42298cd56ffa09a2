"""The grounds of the choice: values of the recommended point in the search and held out, and the gap between them."""

from tuner.documents.parts import row_in_degrees
from tuner.documents.summary import PickedObjective
from tuner.documents.tuning import TuningFolder
from tuner.report.answer_section import estimate_cell
from tuner.report.charts.web import term
from tuner.report.labels import in_plain_words, names_of
from tuner.report.page import aid, collapsible, wide
from tuner.report.words import gap_words
from tuner.text.markup import Markup, element, table
from tuner.text.numbers import significant
from tuner.text.units import marked_up

HEAD = ("Objective", "Unit", "Search", "Held-out", "Held-out − search", "Verdict")

RULES = {"knee": " (the bend of the front, where a little more of one objective begins to cost much of another)"}


def choice_section(results: TuningFolder) -> Markup:
    """Return the reason of the selection, with its values where known."""
    pick, picked = results.document.pick, results.document.picked_on
    if not results.feasible:
        return Markup()
    reason = in_plain_words(pick.why.strip().rstrip("."), names_of(results))
    why = f"Rule {pick.rule}{RULES.get(pick.rule, '')}. The {results.shown_name}: {reason}."
    if not picked:
        return aid(why)
    share = (
        f"{why} It was selected by its held-out values, which are slightly optimistic for that reason; the table at the top uses "
        "independent confirmation flights. Bootstrap probability that no other finalist dominates it: "
        f"{significant(100.0 * picked.probability, 3)} %."
    )
    rows = [[*_row(results, entry), gap_words(picked, entry.gap)] for entry in picked.objectives]
    return collapsible("Selection of the point", aid(share), wide(table(HEAD, rows, class_="stacked")))


def _row(results: TuningFolder, stored: PickedObjective) -> list[Markup]:
    entry = row_in_degrees(stored, "search", "held_out", "gap")
    return [
        term(names_of(results).get(entry.label, entry.label), entry.label),
        marked_up(entry.unit),
        element("span", significant(entry.search), class_="number"),
        estimate_cell(entry.held_out),
        estimate_cell(entry.gap, signed=True),
    ]
