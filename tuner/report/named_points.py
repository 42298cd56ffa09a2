"""The named points of a front: the best in each objective, the knee, the smallest change that helps."""

from tuner.documents.parts import Estimate, row_in_degrees
from tuner.documents.summary import NamedPoint, PointValue
from tuner.documents.tuning import TuningFolder
from tuner.report.answer_section import estimate_cell
from tuner.report.labels import in_plain_words, names_of, point_words
from tuner.report.page import wide
from tuner.text.markup import Markup, element, join, table
from tuner.text.numbers import significant
from tuner.text.units import bracketed

LARGE = 5.0
"""Ratio to the default's value from which on a change is a factor, not per cent."""


def points_table(results: TuningFolder) -> Markup:
    """Return the named points with held-out objectives; nothing where there are none."""
    points, names = results.document.points, names_of(results)
    if not points:
        return Markup()
    first = points[0].objectives
    head = ["Points of the front, held out", *[_title(names, row_in_degrees(entry, "held_out")) for entry in first]]
    rows = [[_name(results, entry), *[_cell(value) for value in entry.objectives]] for entry in points]
    return wide(table(head, rows, class_="points stacked"))


def _title(names: dict[str, str], entry: PointValue) -> str:
    return bracketed(names.get(entry.label, entry.label), entry.unit)


def _name(results: TuningFolder, entry: NamedPoint) -> Markup:
    meaning = in_plain_words(entry.meaning, names_of(results))
    about = f"{meaning}: {entry.name}, {entry.point}{', recommended' if entry.recommended else ''}"
    words = point_words(results, entry.name)
    return join((element("strong" if entry.recommended else "span", words), element("small", f" {about}")))


def _cell(stored: PointValue) -> Markup:
    entry = row_in_degrees(stored, "held_out", "difference")
    return join(
        (
            estimate_cell(entry.held_out),
            element("small", change_text(entry.held_out, entry.difference).replace("-", "−")),
        )
    )


def change_text(value: Estimate, difference: Estimate) -> str:
    """Return the change of a value from the default's: "-12 %", "x 92"; nothing where there is none."""
    if not value.value or not difference.value or value.value == difference.value:
        return ""
    ratio = value.value / (value.value - difference.value)
    return f"x {significant(ratio, 3)}" if ratio >= LARGE else f"{100.0 * (ratio - 1.0):+.3g} %"
