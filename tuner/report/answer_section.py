"""The answer that a page opens with: what got better by how much, margins before and after, and all verdicts in one table."""

import re
from collections.abc import Sequence

from objectives.margins.quantities import QUANTITIES
from tuner.documents.parts import Estimate, ShareCount, in_shown_units
from tuner.documents.states import WORST_MARK, state_table
from tuner.documents.summary import ComparedRow, RequiredRow
from tuner.documents.tuning import DEFAULT, TuningFolder
from tuner.report.labels import plain_margin, plain_metric, plain_risk
from tuner.report.page import wide
from tuner.report.words import law_title, laws_of
from tuner.text.markup import Markup, cells, element, join, table
from tuner.text.numbers import MISSING, count, duration, estimate, fixed, significant
from tuner.text.sentences import bound_text, listing
from tuner.text.units import marked_up, plain

HEAD = ("Quantity", "Default", "Tuned", "Change", "Verdict")
# A sign beside the word, for the quick eye; nothing is said by colour alone.
SIGNS = {"better": "✓", "kept": "✓", "worse": "✗", "broken": "✗", "no clear difference": "≈", "not certain": "≈"}
# Margins told where a study asks for none, and the columns of margins.parquet that they are read from.
WORST = {"phase_margin": ("phase_margin",), "gain_margin": ("gain_up", "gain_down"), "ms": ("ms",)}
MAX_SHARE = 300.0
"""Largest change in per cent of the default's value that is shown as such."""
_LEVEL = re.compile(r"[a-z_]+(\d+(?:\.\d+)?)\(")
_SHARE = re.compile(r"(?:the )?share (1 - )?`level`")


def answer(results: TuningFolder) -> Markup:
    """Return the opening sentences: what the recommended gains change, and on what evidence."""
    return join((_verdict_sentence(results), _margins_sentence(results), _evidence(results)), " ")


def answer_table(results: TuningFolder) -> Markup:
    """Return everything that was judged: objectives, limits on flights, and what is known without flying."""
    head = [name.replace("Tuned", results.shown_as.capitalize()) for name in HEAD]
    top = element("tr", join(element("th", name, scope="col") for name in head))
    groups = [
        ("Objectives: smaller is better", [_row(entry, results.has_rotors) for entry in results.objectives]),
        ("Constraints: kept or broken", [_row(entry, results.has_rotors) for entry in results.constraints]),
        ("Known without flying", [_known_row(entry) for entry in results.requirements]),
        ("Margins, worst of the loops", _margin_rows(results)),
    ]
    bodies = [_group(title, rows, head) for title, rows in groups if rows]
    return element("table", element("thead", top), *bodies, class_="outcome stacked")


def states_table(results: TuningFolder) -> Markup:
    """Return limited margins of the tuned gains in each steady state; nothing where hover is the only one."""
    view = state_table([in_shown_units(row) for row in results.document.required])
    if view is None:
        return Markup("")
    heads = [join((plain_margin(limit), _unit(unit))) for limit, unit in zip(view.limits, view.units, strict=True)]
    rows = [[state, *map(_marked, values)] for state, values in zip(view.states, view.marked, strict=True)]
    about = f"Margins of the {results.shown_as} gains in each steady state; the worst of each in bold."
    return join((element("p", about), wide(table(["Steady state", *heads], rows, class_="states"))))


def _marked(value: str) -> Markup:
    """Return a margin, in bold where it is the worst of its column."""
    number = value.removesuffix(WORST_MARK)
    return element("strong" if value != number else "span", number, class_="number")


def metric_anchor(metric: str) -> str:
    """Return the id of a metric's definition in the page."""
    return "metric-" + "".join(letter if letter.isalnum() else "-" for letter in metric)


def risk_words(label: str, risk: str) -> str:
    """Return a risk in words, its level as the percentage that the label carries: "worst 10 % of the scenarios"."""
    level = _LEVEL.match(label)
    if level is None:
        return risk
    beyond = f"{significant(100.0 - float(level[1]))} %"
    return _SHARE.sub(lambda match: beyond if match[1] else f"{level[1]} %", risk)


def definition_text(quantity: ComparedRow) -> str:
    """Return the definition of a quantity, with its flights."""
    where = "all scenarios" if quantity.scenario is None else f"scenario {quantity.scenario}"
    return f"{quantity.definition}; {risk_words(quantity.label, quantity.risk)}, {where}".replace("`", "")


def verdict(word: str) -> Markup:
    """Return a verdict with its sign."""
    return element("span", f"{SIGNS.get(word, '')} {word}".strip(), class_=f"verdict {word.replace(' ', '-')}")


def change(quantity: ComparedRow) -> tuple[str, str]:
    """Return the difference and its interval as shares of the default's value, as they are where a share tells nothing."""
    default, (value, low, high) = quantity.default.value, quantity.difference
    # Where the default may as well be 0, no multiple of it has a meaning.
    near_zero = quantity.default.low is not None and quantity.default.low <= 0.0
    if not default or default < 0.0 or near_zero or value is None or low is None or high is None:
        return estimate(value, low, high, signed=True)
    shares = [100.0 * part / default for part in (value, low, high)]
    # A multiple of next to nothing says nothing of what it has become.
    if max(map(abs, shares)) > MAX_SHARE:
        return estimate(value, low, high, signed=True)
    decimals = 0 if shares[2] - shares[1] > 2.0 else 1
    middle, bottom, top = (fixed(share, decimals, signed=True) for share in shares)
    return f"{middle} %", f"[{bottom}, {top}]"


def change_in_units(quantity: ComparedRow) -> tuple[str, str]:
    """Return the difference and its interval as `change` does, with the unit where they are no shares."""
    value, ends = change(quantity)
    unit = plain(quantity.unit)
    return value if value.endswith("%") or unit == "1" else f"{value} {unit}", ends


def _verdict_sentence(results: TuningFolder) -> Markup:
    point, why = results.tuned, results.document.pick.why.strip().rstrip(".")
    if not results.feasible:
        return join(
            (element("strong", "Nothing is recommended"), f"; {point} comes nearest and is shown. ", _limits(results))
        )
    if point == DEFAULT:
        return join((element("strong", "The default gains"), f" remain the recommendation: {why}. ", _limits(results)))
    clear = [entry for entry in results.objectives if entry.verdict in ("better", "worse")]
    changes = [" ".join((plain_metric(entry.metric, results.has_rotors), *change_in_units(entry))) for entry in clear]
    even = [
        plain_metric(entry.metric, results.has_rotors)
        for entry in results.objectives
        if entry.verdict == "no clear difference"
    ]
    parts = [element("strong", text) for text in changes]
    head = f"The tuned gains, point {point}, against the default: " if changes else f"Point {point} is recommended. "
    against = join((head, join(parts, ", ")))
    unclear = f"{', ' if changes else ''}no clear difference in {listing(even)}" if even else ""
    return join((against, unclear, ". " if changes or even else "", _limits(results)))


def _limits(results: TuningFolder) -> str:
    limited = [*results.constraints, *results.requirements]
    broken = [entry.label for entry in limited if entry.verdict == "broken"]
    if not limited:
        return ""
    if broken:
        return f"It breaks {listing(broken)}."
    uncertain = [entry.label for entry in limited if entry.verdict == "not certain"]
    return f"Every limit is kept, {listing(uncertain)} by the value alone." if uncertain else "Every limit is kept."


def _margins_sentence(results: TuningFolder) -> Markup:
    margins = [
        (plain_margin(entry.label), entry.default.value, entry.tuned.value, _degrees(plain(entry.unit)))
        for entry in results.requirements
    ] or _worst_margins(results)
    changes = [
        f"{name} {significant(before, 3)} → {significant(after, 3)}{'' if unit == '°' else ' '}{unit}".rstrip()
        for name, before, after, unit in margins[:2]
        if before is not None and after is not None
    ]
    if not changes:
        return Markup()
    text = listing(changes)
    return element("strong", f"{text[:1].upper()}{text[1:]}.")


def _evidence(results: TuningFolder) -> str:
    summary = results.document
    fresh = f"Values are from {count(summary.held_out)} confirmation scenarios with 95 % intervals, of {count(summary.flights)}"
    if summary.wall_seconds is None:
        return f"{fresh} trials that another program made."
    laws = listing([f"{law_title(law)} on {loop}" for law, loop in laws_of(results.resolved)])
    return f"{fresh} simulated flights in {duration(summary.wall_seconds)}; {laws}."


def _group(title: str, rows: Sequence[Sequence[str]], head: list[str]) -> Markup:
    first = element("tr", element("th", title, scope="rowgroup", colspan=len(head)), class_="group")
    return element("tbody", first, *[element("tr", join(cells(head, row))) for row in rows])


def _row(quantity: ComparedRow, rotors: bool) -> list[str]:
    tip = definition_text(quantity)
    link = element("a", plain_metric(quantity.metric, rotors), href=f"#{metric_anchor(quantity.metric)}", data_tip=tip)
    return [
        join((link, _unit(quantity.unit), element("small", _about(quantity)))),
        join((estimate_cell(quantity.default), _count(quantity.default_count))),
        join((estimate_cell(quantity.tuned), _count(quantity.tuned_count))),
        _change_cell(quantity),
        verdict(quantity.verdict),
    ]


def _count(entry: ShareCount | None) -> Markup:
    """Return the count behind a share, with its bound where none was seen."""
    return Markup() if entry is None else element("small", entry.words, class_="interval")


def _about(quantity: ComparedRow) -> Markup:
    """Return risk, label and limit of a quantity in one short line."""
    parts = [plain_risk(quantity.label), element("code", quantity.label)]
    if quantity.limit is not None:
        parts.append(bound_text(quantity.limit))
    if quantity.automatic:
        parts.append(f"automatic limit, {quantity.automatic}")
    return join((part for part in parts if part), ", ")


def _change_cell(quantity: ComparedRow) -> Markup:
    value, ends = change(quantity)
    return element("span", element("strong", value, class_="number"), element("small", ends, class_="interval"))


def _known_row(required: RequiredRow) -> list[str]:
    about = join((element("code", required.label), ", ", bound_text(required.limit, required.sense)))
    name = element("span", plain_margin(required.label), class_="term", tabindex="0", data_tip=required.quantity)
    return [
        join((name, _unit(required.unit), element("small", about))),
        _number(required.default.value),
        _number(required.tuned.value),
        _number(required.difference.value, signed=True),
        verdict(required.verdict),
    ]


def _margin_rows(results: TuningFolder) -> list[list[str]]:
    """Return margins before and after where the study itself asks for none."""
    if results.requirements:
        return []
    return [
        [join((name, _unit(unit))), _number(before), _number(after), _number(after - before, signed=True), ""]
        for name, before, after, unit in _worst_margins(results)
        if before is not None and after is not None
    ]


def _worst_margins(results: TuningFolder) -> list[tuple[str, float | None, float | None, str]]:
    """Return margins of the worst loop as shown: name, default's and tuned's, unit; nothing where the folder holds none."""
    loops_by_role = {
        point: [loop.values for loop in results.loops if loop.point == point] for point in (DEFAULT, results.tuned)
    }
    if not all(loops_by_role.values()):
        return []
    rows = []
    for name, columns in WORST.items():
        quantity = QUANTITIES[name]
        worst = max if quantity.sense == "max" else min
        numbers = [
            [value for loop in loops for key in columns if (value := loop.get(key)) is not None]
            for loops in loops_by_role.values()
        ]
        before, after = (float(quantity.shown(worst(values))) if values else None for values in numbers)
        rows.append(
            (quantity.label, before, after, {"1": "", "deg": "°"}.get(quantity.shown_unit, quantity.shown_unit))
        )
    return rows


def _degrees(unit: str) -> str:
    """Return a unit with one sign for degrees; folders of earlier versions write "deg"."""
    return "°" if unit == "deg" else unit


def _unit(unit: str) -> Markup:
    return join((" [", marked_up(_degrees(unit)), "]")) if unit else Markup()


def estimate_cell(entry: Estimate, signed: bool = False) -> Markup:
    """Return a number over its interval."""
    value, interval = estimate(*entry.parts, signed)
    return element("span", element("span", value, class_="number"), element("small", interval, class_="interval"))


def _number(value: float | None, signed: bool = False) -> Markup:
    if value is None:
        return Markup(MISSING)
    plus = "+" if signed and value > 0.0 else ""
    return element("span", plus + significant(value), class_="number")
