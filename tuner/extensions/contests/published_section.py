"""Printed numbers against the distribution that the same experiment has here: as the paper's table, and as a picture."""

from tuner.documents.comparison import ComparedFolder
from tuner.documents.comparison_document import PublishedRow
from tuner.report.charts.look import looks_of, sample
from tuner.report.charts.strip import StripScale, pinned, ruler, scale
from tuner.text.markup import Markup, element, join
from tuner.text.numbers import MISSING, estimate, fixed, significant
from tuner.text.units import bracketed, marked_up

SIGNS = {True: "✓ inside", False: "✗ outside"}
WORDS = {True: "inside", False: "outside"}
Row = tuple[str, str]
"""Metric and scenario: a row of the printed table."""


def printed_tables(contest: ComparedFolder) -> Markup:
    """Return a table for each airframe in a paper's layout."""
    parts = []
    for airframe in contest.flown:
        names = [entry.name for entry in contest.contenders if entry.flown == airframe]
        cells = [cell for cell in contest.shown.published if cell.contender in names]
        if cells:
            parts.append(element("h3", f"Flown on {airframe}"))
            parts.append(element("div", _table(contest, cells), class_="wide"))
    return join(parts)


def strips(contest: ComparedFolder) -> Markup:
    """Return a figure for each printed row: the central 95 % of our flights with median, and the printed number."""
    return element("div", *[_figure(contest, row) for row in rows_of(contest.shown.published)], class_="forests")


def rows_of(cells: list[PublishedRow]) -> list[Row]:
    """Return the rows of the printed table, in the cells' order."""
    return list(dict.fromkeys((cell.metric, cell.scenario) for cell in cells))


def tally(cells: list[PublishedRow]) -> str:
    """Return "2 of 3", how many printed numbers lie inside; those that the study was set to meet are counted apart."""
    free, fitted = ([cell.inside for cell in cells if cell.fitted is is_fitted] for is_fitted in (False, True))
    text = f"{sum(free)} of {len(free)}"
    return f"{text}; {sum(fitted)} of {len(fitted)} fitted" if fitted else text


def verdict(cell: PublishedRow) -> str:
    """Return the verdict on a printed number: inside or outside, percentile, fitted."""
    return f"{SIGNS[cell.inside]}, percentile {percentile_text(cell.percentile)}{', fitted' if cell.fitted else ''}"


def percentile_text(percentile: float) -> str:
    """Return a percentile, near the ends with a decimal."""
    near = min(percentile, 100.0 - percentile)
    return fixed(percentile, 1 if 0.0 < near < 9.95 else 0)


def _table(contest: ComparedFolder, cells: list[PublishedRow]) -> Markup:
    names = [name for name in contest.index if any(cell.contender == name for cell in cells)]
    heads = [join((sample(looks_of(contest)[name]), element("br"), name)) for name in names]
    top = element("tr", *[element("th", head, scope="col") for head in ("Printed number", "Unit", *heads)])
    body = [_row([cell for cell in cells if (cell.metric, cell.scenario) == row], names) for row in rows_of(cells)]
    foot = [
        element("td", element("div", tally([cell for cell in cells if cell.contender == name])), data_label=name)
        for name in names
    ]
    total = element("tr", element("th", "Inside", scope="row"), element("td"), *foot, class_="total")
    return element("table", element("thead", top), element("tbody", *body, total), class_="values printed stacked")


def _row(cells: list[PublishedRow], names: list[str]) -> Markup:
    by_contender = {cell.contender: _cell(cell) for cell in cells}
    about = ", ".join(part for part in (f"scenario {cells[0].scenario}", cells[0].source) if part)
    head = element("th", element("code", cells[0].metric), element("small", about), scope="row")
    shown = [
        ("Unit", marked_up(cells[0].unit or MISSING)),
        *[(name, by_contender.get(name, Markup(MISSING))) for name in names],
    ]
    return element("tr", head, *[element("td", element("div", cell), data_label=name) for name, cell in shown])


def _cell(cell: PublishedRow) -> Markup:
    mean, ends = estimate(cell.mean, cell.central.low, cell.central.high)
    return element(
        "span",
        element("span", "printed ", element("strong", significant(cell.printed, 6)), class_="number"),
        element("span", f"ours {mean} {ends}", class_="number ours"),
        element("small", verdict(cell), class_=WORDS[cell.inside]),
    )


def _figure(contest: ComparedFolder, row: Row) -> Markup:
    cells = [cell for cell in contest.shown.published if (cell.metric, cell.scenario) == row]
    shown = scale((number for cell in cells for number in (*cell.central, cell.printed)), zero=True)
    caption = element("figcaption", bracketed(row[0], cells[0].unit), element("small", f" scenario {row[1]}"))
    foot = element("div", element("span"), ruler(shown), class_="strip-row", aria_hidden="true")
    return element(
        "figure", caption, element("ul", *[_line(contest, cell, shown) for cell in cells]), foot, class_="forest"
    )


def _line(contest: ComparedFolder, cell: PublishedRow, shown: StripScale) -> Markup:
    look = looks_of(contest)[cell.contender]
    median, ends = estimate(*cell.central.parts)
    printed = element("strong", significant(cell.printed, 6))
    return element(
        "li",
        element("span", sample(look), " ", cell.contender, class_="pair"),
        pinned(shown, cell.central, cell.printed, look, cell.inside),
        element("span", "printed ", printed, element("br"), f"ours {median} {ends}", class_="number"),
        element("span", verdict(cell), class_=f"verdict {WORDS[cell.inside]}"),
        class_="strip-row",
    )
