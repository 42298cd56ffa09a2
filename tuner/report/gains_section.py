"""The tuned gains: a table with their place in the search range, and the same numbers to copy."""

from tuner.documents.summary import VariableRow
from tuner.documents.tuning import TuningFolder
from tuner.report.charts.strip import StripScale, placed
from tuner.text.markup import Markup, element, join, table
from tuner.text.numbers import MISSING, significant
from tuner.text.units import marked_up

HEAD = ("Gain", "Symbol", "Unit", "Default", "Tuned", "Place in the search range")
# Within this share of the range from an end, the search may have wanted to go on.
EDGE = 0.02
# Width of the drawing of a place [px].
WIDTH = 160.0
_GREEK = {"lambda": "λ", "delta": "δ", "zeta": "ζ", "omega": "ω", "alpha": "α", "beta": "β", "gamma": "γ"}


def gains_table(results: TuningFolder) -> Markup:
    """Return the table of searched gains, a row a decision variable."""
    head = [name.replace("Tuned", results.shown_as.capitalize()) for name in HEAD]
    return table(head, [_row(variable) for variable in results.variables], class_="gains stacked")


def symbol(text: str) -> Markup:
    """Return a law's symbol as in print: "wo" as omega with subscript o, "k1" as k with subscript 1."""
    head, tail = text[:1], text[1:].lstrip("_")
    for name, letter in _GREEK.items():
        if text.startswith(name):
            head, tail = letter, text[len(name) :].lstrip("_")
    head = "ω" if head == "w" and tail else head
    return element("i", head, element("sub", tail) if tail else "")


def study_lines(results: TuningFolder) -> str:
    """Return the tuned gains as lines for the [gains] table of a study file."""
    return "\n".join(["[gains]", *[f'"{entry.name}" = {entry.tuned!r}' for entry in results.variables]])


def _row(variable: VariableRow) -> list[str]:
    ends = [significant(variable.low), variable.scale, significant(variable.high)]
    scale = element("span", *[element("span", text) for text in ends], class_="ends")
    return [
        join((element("code", variable.name), element("small", variable.meaning))),
        symbol(variable.symbol or MISSING),
        marked_up(MISSING if variable.unit == "1" else variable.unit),
        element("span", significant(variable.default), class_="number"),
        element("strong", significant(variable.tuned), class_="number"),
        element(
            "span",
            placed(_scale(variable), variable.default, variable.tuned),
            scale,
            element("small", place_remark(variable, variable.tuned)),
            class_="place",
        ),
    ]


def _scale(variable: VariableRow) -> StripScale:
    return StripScale(variable.low, variable.high, variable.scale == "log", WIDTH)


def place_of(variable: VariableRow, value: float) -> float:
    """Return the place of a value in the range, 0 to 1."""
    return _scale(variable).share(value)


def place_remark(variable: VariableRow, value: float) -> str:
    """Return a remark on a value at an end of its range, "" inside it."""
    place = place_of(variable, value)
    if EDGE < place < 1.0 - EDGE:
        return ""
    end = "low" if place <= EDGE else "high"
    why = "which cannot be moved" if end in variable.natural_ends else "a wider range may do better"
    return f"at the {end} end: {why}"
