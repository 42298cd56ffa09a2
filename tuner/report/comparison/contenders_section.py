"""The contenders: laws, airframe, what a search chose, what a control step costs, and where each contender's own report is."""

from typing import NamedTuple
from urllib.parse import quote

from plant.quadrotor.gains import GROUPS
from tuner.documents.comparison import ComparedFolder
from tuner.documents.comparison_document import BoundRow, ContenderRow
from tuner.report.charts.look import looks_of, sample
from tuner.report.words import law_title
from tuner.text.markup import Markup, element, join, table
from tuner.text.numbers import MISSING, count, per_cent, significant
from tuner.text.units import marked_up

BEHIND = [
    "Gains",
    "Operations a step",
    "Instructions a step",
    "Failed flights",
    "Report",
]


class Gain(NamedTuple):
    """One gain of a contender, in the unit of the study file."""

    address: str
    value: float
    unit: str


def contenders_table(compared: ComparedFolder) -> Markup:
    """Return a row a contender."""
    most = max((entry.cost.operations for entry in compared.contenders), default=0.0) or 1.0
    laws = list(dict.fromkeys(loop for entry in compared.contenders for loop in entry.law_of))
    what = "Plant" if any(entry.plant for entry in compared.contenders) else "Airframe"
    head = ["Contender", *[f"{loop[:1].upper()}{loop[1:]} law" for loop in laws], what, *BEHIND]
    return table(
        head, [_row(compared, entry, most, laws) for entry in compared.contenders], class_="contenders stacked"
    )


def gains_cards(compared: ComparedFolder) -> Markup:
    """Return a card a contender with every gain it flew with."""
    return element("div", *[_card(compared, entry) for entry in compared.contenders], class_="cards")


def _row(compared: ComparedFolder, entry: ContenderRow, most: float, laws: list[str]) -> list[Markup | str]:
    report = f"{entry.folder}/report.html"
    has_report = entry.folder is not None and (compared.home / report).exists()
    link = element("a", "its own report", href=quote(report)) if has_report else Markup(MISSING)
    processor = entry.cost.processor
    gains = element("span", entry.point, element("small", "tuned")) if entry.tuned else "as given"
    bar = element(
        "span",
        style=f"width:{60.0 * entry.cost.operations / most:.1f}px",
        class_=f"cost {looks_of(compared)[entry.name].colour}",
    )
    return [
        element("span", sample(looks_of(compared)[entry.name]), " ", element("strong", entry.name), class_="name"),
        *[law_title(entry.law_of[loop]) if loop in entry.law_of else Markup(MISSING) for loop in laws],
        entry.flown,
        gains,
        element("span", element("span", count(entry.cost.operations), class_="number"), bar),
        MISSING if processor is None else element("span", count(processor.instructions_step), class_="number"),
        per_cent(entry.failures),
        link,
    ]


def _card(compared: ComparedFolder, entry: ContenderRow) -> Markup:
    title = element("h3", sample(looks_of(compared)[entry.name]), " ", entry.name)
    about = element(
        "p",
        ", ".join([*[f"{name} on {loop}" for loop, name in entry.law_of.items()], entry.flown]),
        class_="aid",
    )
    gains = [Gain(address, gain.value, gain.unit) for address, gain in entry.gains.items()]
    rows = [_gain_row(gain, gain.address in entry.searched) for gain in joined(gains)]
    notes = element("ul", *[element("li", _bound_text(bound)) for bound in entry.on_bounds], class_="notes")
    listed = element("table", element("tbody", *rows), class_="gain-list")
    return element("article", title, about, listed, notes if entry.on_bounds else "", class_="card")


def _gain_row(gain: Gain, searched: bool) -> Markup:
    unit = marked_up(MISSING if gain.unit == "1" else gain.unit)
    value = element("strong" if searched else "span", significant(gain.value), class_="number")
    return element(
        "tr",
        element("th", element("code", gain.address), scope="row"),
        element("td", value),
        element("td", unit),
        element("td", element("small", "searched" if searched else "")),
    )


def _bound_text(bound: BoundRow) -> Markup:
    who = "the recommended point" if bound.recommended else f"{per_cent(bound.share)} of the front"
    why = "it has no meaning beyond" if bound.natural else "a wider range may do better"
    place = f"{'lower' if bound.end == 'low' else 'upper'} end {significant(bound.bound)}"
    return join((element("code", bound.variable), f" of {who} stands at the {place}: {why}."))


def joined(gains: list[Gain]) -> list[Gain]:
    """Return gains in their order, those of a whole group of axes as one where all have the same value."""
    merged = list(gains)
    for group, axes in ((group, axes) for group, axes in GROUPS.items() if len(axes) > 1):
        for name in dict.fromkeys(gain.address.partition(".")[2] for gain in gains):
            members = [gain for gain in merged if gain.address in [f"{axis}.{name}" for axis in axes]]
            if len(members) == len(axes) and len({gain.value for gain in members}) == 1:
                merged[merged.index(members[0])] = members[0]._replace(address=f"{group}.{name}")
                merged = [gain for gain in merged if gain not in members]
    return merged
