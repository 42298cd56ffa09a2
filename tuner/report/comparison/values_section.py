"""Tables of values: every contender in every quantity, the best under a limit, shares of the common box; ★ marks the best."""

from tuner.documents.comparison import ComparedFolder
from tuner.documents.comparison_document import BestRow, BestUnder, FrontsPart, QuantityRow
from tuner.documents.parts import Estimate, ShareCount
from tuner.report.answer_section import metric_anchor
from tuner.report.charts.look import Look, looks_of, sample
from tuner.report.charts.strip import NARROW, WIDTH, ruler, scale, stacked
from tuner.report.labels import compared_label, risk_words
from tuner.text.markup import Markup, element, join, safe, table
from tuner.text.numbers import MISSING, count, estimate, significant
from tuner.text.sentences import bound_text
from tuner.text.units import marked_up, plain

BEST, CLOSE, BROKEN = "★", "≈", "✗"
# With more contenders than these, columns and drawings are narrow.
MANY = 4
VOLUMES_HEAD = ("Front of", "Points", "Share of the common box (hypervolume)")
KINDS = {
    "objective": "Objectives: smaller is better",
    "constraint": "Limits",
    "published": "Compared with printed numbers",
    "claimed": "Compared for claims",
}


def values_table(compared: ComparedFolder) -> Markup:
    """Return the table, a row a quantity and a column a contender."""
    groups = []
    for kind, title in KINDS.items():
        members = [quantity for quantity in compared.shown.quantities if quantity.kind == kind]
        if members:
            groups.append(_group(compared, title, members))
    many = " many" if len(compared.contenders) > MANY else ""
    return element("table", element("thead", _head(compared)), *groups, class_=f"values{many} stacked")


def quantity_head(compared: ComparedFolder, quantity: QuantityRow) -> Markup:
    """Return the row head of a quantity: name, unit, label and limit."""
    where = "all scenarios" if quantity.scenario is None else f"scenario {quantity.scenario}"
    tip = f"{quantity.definition}; {risk_words(quantity.label, quantity.risk_text)}, {where}".replace("`", "")
    name = compared_label(compared, quantity.label)
    link = element("a", name, href=f"#{metric_anchor(quantity.metric)}", data_tip=tip)
    about = element("code", quantity.label)
    if quantity.limit is not None:
        about = join((about, ", ", bound_text(quantity.limit)))
    unit = join((" [", marked_up(quantity.unit), "]")) if quantity.unit else Markup()
    return join((link, unit, element("small", about)))


def _head(compared: ComparedFolder) -> Markup:
    names = [join((sample(looks_of(compared)[entry.name]), element("br"), entry.name)) for entry in compared.contenders]
    return element("tr", *[element("th", name, scope="col") for name in ("Quantity", *names, "On one scale")])


def _group(compared: ComparedFolder, title: str, members: list[QuantityRow]) -> Markup:
    columns = str(len(compared.contenders) + 2)
    head = element("tr", element("th", title, scope="rowgroup", colspan=columns), class_="group")
    return element("tbody", head, *[element("tr", *_row(compared, quantity)) for quantity in members])


def _row(compared: ComparedFolder, quantity: QuantityRow) -> list[Markup]:
    best, close = compared.best(quantity.label), compared.words_beside_best(quantity.label)
    estimates = [(entry, compared.estimates.get((entry.name, quantity.label))) for entry in compared.contenders]
    counts = [compared.counts.get((entry.name, quantity.label)) for entry in compared.contenders]
    shown = [
        _cell(quantity, value, entry.name in best, entry.name in close, count)
        for (entry, value), count in zip(estimates, counts, strict=True)
    ]
    available = [(looks_of(compared)[entry.name], value) for entry, value in estimates if value is not None]
    drawn = _drawing(available, quantity.limit, NARROW if len(compared.contenders) > MANY else WIDTH)
    names = [*[entry.name for entry in compared.contenders], "On one scale"]
    content = [*shown, drawn]
    cells = [element("td", element("div", cell), data_label=name) for name, cell in zip(names, content, strict=True)]
    return [element("th", quantity_head(compared, quantity), scope="row"), *cells]


def _drawing(rows: list[tuple[Look, Estimate]], limit: float | None, width: float) -> Markup:
    """Return all contenders on one scale; nothing where all their numbers are zero."""
    numbers = [*[number for _, entry in rows for number in entry], limit]
    if not any(numbers):
        return Markup()
    span = scale(numbers)._replace(width=width)
    return join((stacked(span, rows, limit), ruler(span)))


def _cell(quantity: QuantityRow, entry: Estimate | None, best: bool, close: bool, count: ShareCount | None) -> Markup:
    if entry is None:
        return Markup(MISSING)
    value, interval = estimate(*entry.parts)
    sign = f"{BEST} " if best else f"{CLOSE} " if close else ""
    number = element("strong" if best else "span", sign, value, class_="number")
    broken = quantity.limit is not None and entry.value is not None and entry.value > quantity.limit
    remark = element("small", f"{BROKEN} limit violated", class_="broken") if broken else ""
    seen = "" if count is None else element("small", count.words, class_="interval")
    return element("span", number, element("small", interval, class_="interval"), seen, remark)


def best_table(compared: ComparedFolder) -> Markup:
    """Return the table, a row a question and a column a contender with a front."""
    contenders = {row.contender for entry in compared.shown.best_under for row in entry.rows}
    names = [name for name in compared.index if name in contenders]
    heads = [join((sample(looks_of(compared)[name]), element("br"), name)) for name in names]
    top = element("tr", *[element("th", head, scope="col") for head in ("Smallest", *heads)])
    rows = [_best_row(compared, entry, names) for entry in compared.shown.best_under]
    return element("table", element("thead", top), element("tbody", *rows), class_="values stacked")


def _best_row(compared: ComparedFolder, entry: BestUnder, names: list[str]) -> Markup:
    objective, other = compared.quantity[entry.objective], compared.quantity[entry.subject_to]
    condition = join(
        ("with ", compared_label(compared, other.label), f" at most {significant(entry.limit)} ", marked_up(other.unit))
    )
    unit = join((" [", marked_up(objective.unit), "]")) if objective.unit else Markup()
    head = join((compared_label(compared, objective.label), unit, element("small", condition)))
    rows = {row.contender: row for row in entry.rows}
    values = {name: row.value for name, row in rows.items() if row.value is not None}
    best = min(values, key=lambda name: values[name]) if values else None
    cells = [element("td", element("div", _best_cell(rows.get(name), name == best)), data_label=name) for name in names]
    return element("tr", element("th", head, scope="row"), *cells)


def _best_cell(row: BestRow | None, best: bool) -> Markup:
    if row is None or row.point is None:
        return element("small", "no point satisfies it")
    value, interval = estimate(*row.estimate.parts)
    number = element("strong" if best else "span", f"{BEST} " if best else "", value, class_="number")
    return element("span", number, element("small", interval, class_="interval"), element("small", safe(row.point)))


def volumes_table(compared: ComparedFolder, fronts: FrontsPart) -> Markup:
    """Return a row a front; the larger the share, the better."""
    shares = {row.contender: row.value for row in fronts.hypervolume}
    best = {name for name, share in shares.items() if share == max(shares.values())}
    rows = []
    for entry in fronts.hypervolume:
        value, ends = estimate(*entry.estimate.parts)
        largest = entry.contender in best
        sign = f"{BEST} " if largest else f"{CLOSE} " if fronts.even_with(entry.contender) & best else ""
        number = element("strong" if largest else "span", sign, value, class_="number")
        name = join((sample(looks_of(compared)[entry.contender]), " ", entry.contender))
        points = count(fronts.size(entry.contender))
        rows.append([name, points, element("span", number, " ", element("small", ends, class_="interval"))])
    reference = [(compared.quantity[label], value) for label, value in fronts.reference.items()]
    corner = ", ".join(
        f"{compared_label(compared, entry.label)} {significant(value, 3)} {plain(entry.unit)}".rstrip()
        for entry, value in reference
    )
    note = element("p", f"The far corner of the box: {corner}.", class_="aid")
    return join((table(VOLUMES_HEAD, rows, class_="volumes stacked"), note))
