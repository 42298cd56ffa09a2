"""Who flew: laws, airframe, what a search chose, what a control step costs, and where each contender's own report is."""

from urllib.parse import quote

from tuner.documents.contest import BoundRow, Gain, ShownContender, ShownContest
from tuner.report.charts.look import looks_of, sample
from tuner.report.contest.shown import joined
from tuner.report.prose import law_title
from tuner.text.markup import Markup, element, join, table
from tuner.text.numbers import MISSING, count, per_cent, significant
from tuner.text.units import marked_up

HEAD = [
    "Contender",
    "Attitude law",
    "Position law",
    "Airframe",
    "Gains",
    "Operations a step",
    "Instructions a step",
    "Failed flights",
    "Report",
]


def contenders_table(contest: ShownContest) -> Markup:
    """Return a row a contender."""
    most = max((entry.operations for entry in contest.contenders), default=0.0) or 1.0
    return table(HEAD, [_row(contest, entry, most) for entry in contest.contenders], class_="contenders stacked")


def gains_cards(contest: ShownContest) -> Markup:
    """Return a card a contender with every gain it flew with."""
    return element("div", *[_card(contest, entry) for entry in contest.contenders], class_="cards")


def _row(contest: ShownContest, entry: ShownContender, most: float) -> list[Markup | str]:
    here = bool(entry.folder) and (contest.folder / entry.folder / "report.html").exists()
    link = element("a", "its own report", href=f"{quote(entry.folder)}/report.html") if here else Markup(MISSING)
    gains = element("span", entry.point, element("small", "tuned")) if entry.tuned else "as given"
    bar = element(
        "span",
        style=f"width:{60.0 * entry.operations / most:.1f}px",
        class_=f"cost {looks_of(contest)[entry.name].colour}",
    )
    return [
        element("span", sample(looks_of(contest)[entry.name]), " ", element("strong", entry.name), class_="name"),
        law_title(entry.laws["attitude"]),
        law_title(entry.laws["position"]),
        entry.airframe,
        gains,
        element("span", element("span", count(entry.operations), class_="number"), bar),
        MISSING if entry.instructions is None else element("span", count(entry.instructions), class_="number"),
        per_cent(entry.failures),
        link,
    ]


def _card(contest: ShownContest, entry: ShownContender) -> Markup:
    title = element("h3", sample(looks_of(contest)[entry.name]), " ", entry.name)
    about = element(
        "p",
        f"{entry.laws['attitude']} on attitude, {entry.laws['position']} on position, {entry.airframe}",
        class_="aid",
    )
    rows = [_gain_row(gain, gain.address in entry.searched) for gain in joined(entry.gains)]
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
