"""The grounds of the choice: values of the recommended point in the search and held out, and the gap between them."""

from tuner.documents.parts import row_in_degrees
from tuner.documents.summary import PickedObjective
from tuner.documents.tuning import TuningFolder
from tuner.report.answer_section import estimate_cell
from tuner.report.page import aid, collapsible, wide
from tuner.report.words import gap_words
from tuner.text.markup import Markup, element, table
from tuner.text.numbers import significant
from tuner.text.units import marked_up

HEAD = ("Objective", "Unit", "Search", "Held-out", "Held-out − search", "What it says")

RULES = {"knee": "the bend of the front, where a little more of one objective begins to cost much of another. "}


def choice_section(results: TuningFolder) -> Markup:
    """Return why the point was chosen, with the values it was chosen by where the folder holds them."""
    pick, picked = results.document.pick, results.document.picked_on
    if not results.feasible:
        return Markup()
    why = f"Rule {pick.rule}: {RULES.get(pick.rule, '')}Of {results.tuned} it says: {pick.why.strip().rstrip('.')}."
    if not picked:
        return aid(why)
    share = (
        f"{why} It was chosen by its held-out values, which flatters them a little; the table at the top rests on flights that "
        f"had no part in the choice. On {significant(100.0 * picked.probability, 3)} % of the resamples no other finalist is "
        "better in everything."
    )
    rows = [[*_row(entry), gap_words(picked, entry.gap)] for entry in picked.objectives]
    return collapsible("How it was chosen", aid(share), wide(table(HEAD, rows, class_="stacked")))


def _row(stored: PickedObjective) -> list[Markup]:
    entry = row_in_degrees(stored, "search", "held_out", "gap")
    return [
        element("code", entry.label),
        marked_up(entry.unit),
        element("span", significant(entry.search), class_="number"),
        estimate_cell(entry.held_out),
        estimate_cell(entry.gap, signed=True),
    ]
