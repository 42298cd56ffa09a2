"""The Default / Tuned table: objectives and constraints on confirmation scenarios, with intervals, and requirements without.

Every row ends in a verdict.
"""

import re
from collections.abc import Sequence

from tuner.documents.parts import Estimate
from tuner.documents.results import Quantity, Required, Results
from tuner.report.drawings import intervals
from tuner.report.prose import limit_text
from tuner.text.markup import Markup, cells, coded, element, join
from tuner.text.numbers import MISSING, estimate, fixed, significant
from tuner.text.units import marked_up

HEAD = ["Quantity", "Unit", "Limit", "Default", "Tuned", "Tuned − default", "From zero", "Verdict"]
_LEVEL = re.compile(r"[a-z_]+(\d+(?:\.\d+)?)\(")
_SHARE = re.compile(r"(?:the )?share (1 - )?`level`")
# A sign beside the word, for the quick eye; nothing is said by colour alone.
SIGNS = {"better": "✓", "kept": "✓", "worse": "✗", "broken": "✗", "no clear difference": "≈"}


def outcome_table(results: Results) -> Markup:
    """Return the table, objectives first."""
    head = [name.replace("Tuned", results.shown_as.capitalize()) for name in HEAD]
    top = element("tr", join(element("th", name, scope="col") for name in head))
    groups = [_group("Objectives: smaller is better", [_row(entry) for entry in results.objectives], head)]
    if results.constraints:
        groups.append(_group("Constraints: kept or broken", [_row(entry) for entry in results.constraints], head))
    if results.requirements:
        rows = [_known_row(entry) for entry in results.requirements]
        groups.append(_group("Requirements known without flying: kept or broken", rows, head))
    return element("table", element("thead", top), *groups, class_="outcome stacked")


def metric_anchor(quantity: Quantity) -> str:
    """Return the id of a metric's definition in the page."""
    return "metric-" + "".join(letter if letter.isalnum() else "-" for letter in quantity.metric)


def _group(title: str, rows: Sequence[Sequence[str]], head: list[str]) -> Markup:
    first = element("tr", element("th", title, scope="rowgroup", colspan=len(head)), class_="group")
    return element("tbody", first, *[element("tr", join(cells(head, row))) for row in rows])


def _row(quantity: Quantity) -> list[str]:
    link = element(
        "a",
        element("code", quantity.label),
        href=f"#{metric_anchor(quantity)}",
        data_tip=quantity.definition.replace("`", ""),
    )
    where = "all scenarios" if quantity.scenario is None else f"scenario {quantity.scenario}"
    automatic = f"; automatic limit, {quantity.automatic}" if quantity.automatic else ""
    about = join((coded(risk_text(quantity)), ", ", where, automatic))
    return [
        join((link, element("small", about))),
        marked_up(quantity.unit or MISSING),
        MISSING if quantity.limit is None else limit_text(quantity.limit, ""),
        _numbers(quantity.default),
        _numbers(quantity.tuned),
        _numbers(quantity.difference, signed=True, remark=_relative(quantity)),
        intervals(quantity),
        _verdict(quantity.verdict),
    ]


def _known_row(required: Required) -> list[str]:
    return [
        join((element("code", required.label), element("small", required.quantity))),
        marked_up(required.unit or MISSING),
        limit_text(required.limit, "", required.sense),
        _number(required.default.value),
        _number(required.tuned.value),
        _number(required.difference.value, signed=True),
        intervals(required),
        _verdict(required.verdict),
    ]


def _verdict(word: str) -> Markup:
    return element("span", f"{SIGNS.get(word, '')} {word}".strip(), class_=f"verdict {word.replace(' ', '-')}")


def risk_text(quantity: Quantity) -> str:
    """Return the risk of a quantity in words, see `risk_words`."""
    return risk_words(quantity.label, quantity.risk)


def risk_words(label: str, risk: str) -> str:
    """Return a risk in words, its level as the percentage that the label carries: "worst 10 % of the scenarios"."""
    level = _LEVEL.match(label)
    if level is None:
        return risk
    beyond = f"{significant(100.0 - float(level[1]))} %"
    return _SHARE.sub(lambda found: beyond if found[1] else f"{level[1]} %", risk)


def _numbers(entry: Estimate, signed: bool = False, remark: str = "") -> Markup:
    value, interval = estimate(entry.value, entry.low, entry.high, signed)
    number = element("span", value, f" ({remark})" if remark else "", class_="number")
    return element("span", number, element("small", interval, class_="interval"))


def _number(value: float | None, signed: bool = False) -> Markup:
    plus = "+" if signed and value is not None and value > 0.0 else ""
    return element("span", plus + significant(value), class_="number")


def _relative(quantity: Quantity) -> str:
    """Return the difference as a share of the default's value, where that says something."""
    default, difference = quantity.default.value, quantity.difference.value
    if difference is None or not default or default < 0.0:
        return ""
    return f"{fixed(100.0 * difference / default, 0, signed=True)} %"
