"""What each contender offers under a limit: the best value of one objective with another held down."""

from tuner.documents.contest import ShownBest, ShownBestUnder, ShownContest
from tuner.report.charts.look import looks_of, sample
from tuner.report.contest.values_section import BEST
from tuner.text.markup import Markup, element, join, safe
from tuner.text.numbers import estimate, significant
from tuner.text.units import marked_up


def best_table(contest: ShownContest) -> Markup:
    """Return the table, a row a question and a column a contender with a front."""
    names = [name for name in contest.index if any(name in entry.rows for entry in contest.best_under)]
    heads = [join((sample(looks_of(contest)[name]), element("br"), name)) for name in names]
    top = element("tr", *[element("th", head, scope="col") for head in ("Smallest", *heads)])
    rows = [_row(contest, entry, names) for entry in contest.best_under]
    return element("table", element("thead", top), element("tbody", *rows), class_="values stacked")


def _row(contest: ShownContest, entry: ShownBestUnder, names: list[str]) -> Markup:
    objective, other = contest.quantity[entry.objective], contest.quantity[entry.subject_to]
    condition = join(
        ("with ", element("code", other.label), f" at most {significant(entry.limit)} ", marked_up(other.unit))
    )
    unit = join((" [", marked_up(objective.unit), "]")) if objective.unit else Markup()
    head = join((element("code", objective.label), unit, element("small", condition)))
    known = {name: row.estimate.value for name, row in entry.rows.items() if row and row.estimate.value is not None}
    best = min(known, key=lambda name: known[name]) if known else None
    cells = [
        element("td", element("div", _cell(entry.rows.get(name), name == best)), data_label=name) for name in names
    ]
    return element("tr", element("th", head, scope="row"), *cells)


def _cell(row: ShownBest | None, best: bool) -> Markup:
    if row is None:
        return element("small", "no point keeps it")
    value, interval = estimate(*row.estimate.parts)
    number = element("strong" if best else "span", f"{BEST} " if best else "", value, class_="number")
    return element("span", number, element("small", interval, class_="interval"), element("small", safe(row.point)))
