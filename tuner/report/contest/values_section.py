"""Every contender in every quantity on the same flights, the best marked by a sign and not by colour alone."""

from tuner.documents.contest import ShownContest, ShownQuantity
from tuner.documents.parts import Estimate
from tuner.report.answer_section import metric_anchor, risk_words
from tuner.report.charts.look import Look, looks_of, sample
from tuner.report.charts.strip import NARROW, WIDTH, ruler, scale, stacked
from tuner.report.prose import limit_text
from tuner.text.markup import Markup, coded, element, join
from tuner.text.numbers import MISSING, estimate
from tuner.text.units import marked_up, plain

BEST, CLOSE, BROKEN = "★", "≈", "✗"
# With more contenders than these, columns and drawings are narrow.
MANY = 4
KINDS = {
    "objective": "Objectives: smaller is better",
    "constraint": "Constraints: kept or broken",
    "published": "Asked for by printed numbers",
    "claimed": "Asked for by claims",
}


def values_table(contest: ShownContest) -> Markup:
    """Return the table, a row a quantity and a column a contender."""
    groups = []
    for kind, title in KINDS.items():
        members = [quantity for quantity in contest.quantities if quantity.kind == kind]
        if members:
            groups.append(_group(contest, title, members))
    many = " many" if len(contest.contenders) > MANY else ""
    return element("table", element("thead", _head(contest)), *groups, class_=f"values{many} stacked")


def quantity_head(quantity: ShownQuantity) -> Markup:
    """Return label, unit, risk and scenario of a quantity, the label linked to the metric's definition."""
    name = element("code", quantity.label.removesuffix(f"@{quantity.scenario}"))
    link = element("a", name, href=f"#{metric_anchor(quantity.metric)}")
    where = "all scenarios" if quantity.scenario is None else f"scenario {quantity.scenario}"
    about = join((coded(risk_words(quantity.label, quantity.risk)), ", ", where))
    if quantity.limit is not None:
        about = join((limit_text(quantity.limit, plain(quantity.unit)), "; ", about))
    unit = join((" [", marked_up(quantity.unit), "]")) if quantity.unit else Markup()
    return join((link, unit, element("small", about)))


def _head(contest: ShownContest) -> Markup:
    names = [join((sample(looks_of(contest)[entry.name]), element("br"), entry.name)) for entry in contest.contenders]
    return element("tr", *[element("th", name, scope="col") for name in ("Quantity", *names, "On one scale")])


def _group(contest: ShownContest, title: str, members: list[ShownQuantity]) -> Markup:
    columns = str(len(contest.contenders) + 2)
    head = element("tr", element("th", title, scope="rowgroup", colspan=columns), class_="group")
    return element("tbody", head, *[element("tr", *_row(contest, quantity)) for quantity in members])


def _row(contest: ShownContest, quantity: ShownQuantity) -> list[Markup]:
    best, close = contest.best(quantity.label), contest.close_to_best(quantity.label)
    found = [(entry, contest.estimates.get((entry.name, quantity.label))) for entry in contest.contenders]
    shown = [_cell(quantity, value, entry.name in best, entry.name in close) for entry, value in found]
    known = [(looks_of(contest)[entry.name], value) for entry, value in found if value is not None]
    drawn = _drawing(known, quantity.limit, NARROW if len(contest.contenders) > MANY else WIDTH)
    names = [*[entry.name for entry in contest.contenders], "On one scale"]
    content = [*shown, drawn]
    cells = [element("td", element("div", cell), data_label=name) for name, cell in zip(names, content, strict=True)]
    return [element("th", quantity_head(quantity), scope="row"), *cells]


def _drawing(rows: list[tuple[Look, Estimate]], limit: float | None, width: float) -> Markup:
    """Return all contenders on one scale; nothing where all their numbers are zero."""
    numbers = [*[number for _, entry in rows for number in entry], limit]
    if not any(numbers):
        return Markup()
    span = scale(numbers)._replace(width=width)
    return join((stacked(span, rows, limit), ruler(span)))


def _cell(quantity: ShownQuantity, entry: Estimate | None, best: bool, close: bool) -> Markup:
    if entry is None:
        return Markup(MISSING)
    value, interval = estimate(*entry.parts)
    sign = f"{BEST} " if best else f"{CLOSE} " if close else ""
    number = element("strong" if best else "span", sign, value, class_="number")
    broken = quantity.limit is not None and entry.value is not None and entry.value > quantity.limit
    remark = element("small", f"{BROKEN} limit broken", class_="broken") if broken else ""
    return element("span", number, element("small", interval, class_="interval"), remark)
