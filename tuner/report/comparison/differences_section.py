"""Paired differences: a forest plot a quantity, each row a pair of contenders with difference, interval and verdict."""

from tuner.documents.comparison import ComparedFolder
from tuner.documents.comparison_document import DifferenceRow, QuantityRow
from tuner.documents.verdicts import signed_verdict
from tuner.report.changes import relative_change
from tuner.report.charts.look import looks_of, sample
from tuner.report.charts.strip import StripScale, interval, ruler, scale
from tuner.report.charts.web import term
from tuner.report.labels import compared_label
from tuner.text.markup import Markup, element, join
from tuner.text.numbers import estimate
from tuner.text.sentences import listing
from tuner.text.units import bracketed

# Quantities whose forest plots stand open; the others are folded away.
OPEN_KINDS = ("objective", "constraint")


def forests(compared: ComparedFolder) -> Markup:
    """Return a card for each quantity with differences; those that only printed numbers or claims ask for are folded."""
    shown, collapsible, same = [], [], []
    for quantity in compared.shown.quantities:
        rows = [entry for entry in compared.shown.differences if entry.quantity == quantity.label]
        if rows and not any(number for entry in rows for number in entry.estimate):
            same.append(compared_label(compared, quantity.label))
        elif rows:
            (shown if quantity.kind in OPEN_KINDS else collapsible).append(_card(compared, quantity, rows))
    if not shown:
        shown, collapsible = collapsible, []
    parts = [element("p", f"No two contenders differ at all in {listing(same)}.", class_="aid")] if same else []
    parts.append(element("div", *shown, class_="forests"))
    if collapsible:
        what = f"{len(collapsible)} more: quantities of printed numbers and claims"
        inner = element("div", *collapsible, class_="forests")
        parts.append(element("details", element("summary", what), inner, class_="plain"))
    return join(parts)


def related(compared: ComparedFolder, entry: DifferenceRow) -> bool:
    """Say whether two contenders share the airframe or the laws; a difference in both says little about either."""
    first, second = (compared.contenders[compared.index[name]] for name in (entry.first, entry.second))
    return first.flown == second.flown or first.law_of == second.law_of


def _card(compared: ComparedFolder, quantity: QuantityRow, rows: list[DifferenceRow]) -> Markup:
    shown = scale(number for entry in rows for number in entry.estimate)
    near = [_row(compared, quantity, entry, shown) for entry in rows if related(compared, entry)]
    far = [_row(compared, quantity, entry, shown) for entry in rows if not related(compared, entry)]
    foot = element("div", element("span"), ruler(shown), class_="strip-row", aria_hidden="true")
    parts = [
        element("figcaption", term(bracketed(compared_label(compared, quantity.label), quantity.unit), quantity.label)),
        element("ul", *near),
        foot,
    ]
    if far:
        what = element("summary", f"{len(far)} pairs that differ in laws and airframe")
        parts.append(element("details", what, element("ul", *far), class_="plain"))
    return element("figure", *parts, class_="forest")


def _row(compared: ComparedFolder, quantity: QuantityRow, entry: DifferenceRow, shown: StripScale) -> Markup:
    second, first = (_name(compared, name) for name in (entry.second, entry.first))
    value, ends = estimate(*entry.estimate.parts, signed=True)
    share = _relative(compared, quantity, entry)
    number = element("strong", value, f" ({share})" if share else "")
    return element(
        "li",
        element("span", second, " − ", first, class_="pair"),
        interval(shown, entry.estimate, entry.lower is not None),
        element("span", number, " ", element("small", ends, class_="interval"), class_="number"),
        _verdict(entry),
        class_="strip-row",
    )


def _name(compared: ComparedFolder, name: str) -> Markup:
    return element("span", sample(looks_of(compared)[name]), " ", name, class_="name")


def _verdict(entry: DifferenceRow) -> Markup:
    if entry.lower is None:
        return element("span", signed_verdict(entry.verdict), class_="verdict undecided")
    return element("span", f"✓ {entry.lower} is lower", class_="verdict")


def _relative(compared: ComparedFolder, quantity: QuantityRow, entry: DifferenceRow) -> str:
    """Return the difference in per cent of the first contender's value, or ""."""
    first = compared.estimates.get((entry.first, quantity.label))
    relative = None if first is None else relative_change(first, entry.estimate)
    return relative[0] if relative else ""
