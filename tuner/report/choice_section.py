"""What the recommended point was chosen by: its values in the search and held out, how far they are apart."""

from typing import Any

from tuner.documents.results import Results
from tuner.report.prose import gap_words
from tuner.text.markup import Markup, element, join, table
from tuner.text.numbers import estimate, significant
from tuner.text.units import in_degrees, marked_up

HEAD = ["Objective", "Unit", "Search", "Held-out", "Held-out − search", "What it says"]


def choice_section(results: Results) -> Markup:
    """Return the table and the sentences, nothing where a folder does not hold them or nothing was chosen."""
    picked = results.summary.get("picked_on")
    if not picked or not results.feasible:
        return Markup()
    share = (
        f"{results.tuned} was chosen by its held-out values, which flatters them a little; the table above rests on flights "
        f"that had no part in the choice. It is non-dominated on {significant(100.0 * picked['probability'], 3)} % of the "
        "resamples."
    )
    rows = [[*_row(entry), gap_words(picked, entry["gap"])] for entry in picked["objectives"]]
    about = element("p", share, class_="aid")
    return join((element("h3", "How it was chosen"), about, table(HEAD, rows, class_="stacked")))


def _row(entry: dict[str, Any]) -> list[Markup]:
    unit, factor = in_degrees(entry["unit"])
    return [
        element("code", entry["label"]),
        marked_up(unit),
        element("span", significant(entry["search"] * factor), class_="number"),
        _numbers(entry["held_out"], factor),
        _numbers(entry["gap"], factor, signed=True),
    ]


def _numbers(entry: dict[str, float], factor: float, signed: bool = False) -> Markup:
    value, interval = estimate(*[entry[key] * factor for key in ("value", "low", "high")], signed=signed)
    number = element("span", value, class_="number")
    return element("span", number, element("small", interval, class_="interval"))
