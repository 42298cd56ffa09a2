"""The answer that a page opens with: what got better by how much, margins before and after, and all verdicts in one table."""

from collections.abc import Sequence

from objectives.margins.quantities import QUANTITIES
from objectives.risk.differences import BETTER, WORSE
from tuner.documents.parts import Estimate, in_shown_units
from tuner.documents.states import WORST_MARK, state_table
from tuner.documents.summary import ComparedRow, RequiredRow
from tuner.documents.tuning import DEFAULT, TuningFolder
from tuner.documents.verdicts import signed_verdict
from tuner.report.changes import headline_change
from tuner.report.labels import definition_text, named, plain_margin
from tuner.report.page import wide
from tuner.report.verdict_text import verdict_text
from tuner.report.words import law_title, laws_of
from tuner.text.markup import Markup, cells, element, join, table
from tuner.text.numbers import MISSING, count, duration, estimate, plus, significant
from tuner.text.sentences import bound_text, capitalized, listing
from tuner.text.units import marked_up, plain

HEAD = ("Quantity", "Default", "Tuned", "Change", "Verdict")
# Margins told where a study asks for none, and the columns of margins.npz that they are read from.
WORST = {"phase_margin": ("phase_margin",), "gain_margin": ("gain_up", "gain_down"), "ms": ("ms",)}


def answer(results: TuningFolder) -> Markup:
    """Return the opening paragraphs: the verdict, then the changes and the evidence."""
    sentences = (*_changes(results), _evidence(results))
    return join(
        (element("p", verdict_text(results), class_="answer"), element("p", join(sentences, " "), class_="lead"))
    )


def answer_table(results: TuningFolder) -> Markup:
    """Return everything that was judged: objectives, limits on flights, and what is known without flying."""
    head = [name.replace("Tuned", results.shown_as.capitalize()) for name in HEAD]
    top = element("tr", join(element("th", name, scope="col") for name in head))
    groups = [
        ("Objectives: smaller is better", [_row(results, entry) for entry in results.objectives]),
        ("Limits", [_row(results, entry) for entry in results.constraints]),
        ("Limits computed from the model", [_known_row(entry) for entry in results.requirements]),
        ("Margins, worst of the loops", _margin_rows(results)),
    ]
    bodies = [_group(title, rows, head) for title, rows in groups if rows]
    return element("table", element("thead", top), *bodies, class_="outcome stacked")


def states_table(results: TuningFolder) -> Markup:
    """Return limited margins of the tuned gains in each steady state; nothing where hover is the only one."""
    view = state_table([in_shown_units(row) for row in results.document.required])
    if view is None:
        return Markup("")
    units = ["" if unit == "1" else unit for unit in view.units]
    heads = [join((plain_margin(limit), _unit(unit))) for limit, unit in zip(view.limits, units, strict=True)]
    rows = [[state, *map(_marked, values)] for state, values in zip(view.states, view.marked, strict=True)]
    about = f"Margins of the {results.shown_as} gains in each steady state; the worst of each in bold."
    return join(
        (element("p", about, class_="aid"), wide(table(["Steady state", *heads], rows, class_="states stacked")))
    )


def _marked(value: str) -> Markup:
    """Return a margin, in bold if the worst of its column."""
    number = value.removesuffix(WORST_MARK)
    return element("strong" if value != number else "span", number, class_="number")


def metric_anchor(metric: str) -> str:
    """Return the id of a metric's definition in the page."""
    return "metric-" + "".join(letter if letter.isalnum() else "-" for letter in metric)


def verdict(word: str) -> Markup:
    """Return a verdict with its sign."""
    return element("span", signed_verdict(word), class_=f"verdict {word.replace(' ', '-')}")


def _changes(results: TuningFolder) -> list[str]:
    """Return sentences on changes that matter and on margins."""
    recommended = results.feasible and results.tuned != DEFAULT
    rows = [row for row in results.objectives if recommended and row.verdict in (BETTER, WORSE)]
    changes = [
        f"{named(results, row, short=True)}: {headline_change(row.default, row.difference, row.unit)}" for row in rows
    ]
    return [capitalized(text) for text in ("; ".join(changes), _margins_text(results)) if text]


def _margins_text(results: TuningFolder) -> str:
    """Return two margins before and after, once if the default stays; "" where none are known."""
    stays = results.tuned == DEFAULT
    margins = [
        (plain_margin(entry.label), entry.default.value, entry.tuned.value, _degrees(plain(entry.unit)))
        for entry in results.requirements
    ] or _worst_margins(results)
    return listing(
        f"{name} {significant(before, 3)}{'' if stays else f' → {significant(after, 3)}'}{_behind_number(unit)}"
        for name, before, after, unit in margins[:2]
        if before is not None and after is not None
    )


def _behind_number(unit: str) -> str:
    """Return a unit behind a number: a degree without a space."""
    return unit if unit in ("", "°") else f" {unit}"


def _evidence(results: TuningFolder) -> str:
    summary = results.document
    fresh = f"Values are from {count(summary.held_out)} confirmation scenarios with 95 % intervals, of {count(summary.flights)}"
    if summary.wall_seconds is None:
        return f"{fresh} trials run by another program."
    laws = listing([f"{law_title(law)} on {loop}" for law, loop in laws_of(results.resolved)])
    return f"{fresh} {results.sample_noun} in {duration(summary.wall_seconds)}; {laws}."


def _group(title: str, rows: Sequence[Sequence[str]], head: list[str]) -> Markup:
    first = element("tr", element("th", title, scope="rowgroup", colspan=len(head)), class_="group")
    return element("tbody", first, *[element("tr", join(cells(head, row))) for row in rows])


def _row(results: TuningFolder, quantity: ComparedRow) -> list[str]:
    tip = definition_text(quantity)
    name = named(results, quantity, short=True)
    link = element("a", name, href=f"#{metric_anchor(quantity.metric)}", data_tip=tip)
    return [
        join((link, _unit(quantity.unit), element("small", _about(quantity)))),
        *[
            join((estimate_cell(entry), _evidence_line(words)))
            for entry, words in zip((quantity.default, quantity.tuned), quantity.evidence, strict=True)
        ],
        estimate_cell(quantity.difference, signed=True),
        verdict(quantity.verdict),
    ]


def _evidence_line(words: str) -> Markup:
    """Return the line below a value that says what it rests on."""
    return element("small", words, class_="interval") if words else Markup()


def _about(quantity: ComparedRow) -> Markup:
    """Return label and limit of a quantity in one short line."""
    parts: list[str] = [element("code", quantity.label)]
    if quantity.limit is not None:
        parts.append(bound_text(quantity.limit))
    if quantity.automatic:
        parts.append(f"automatic limit, {quantity.automatic}")
    return join(parts, ", ")


def _known_row(required: RequiredRow) -> list[str]:
    about = join((element("code", required.label), ", ", bound_text(required.limit, required.sense)))
    name = element(
        "span", plain_margin(required.label), class_="term", tabindex="0", data_tip=definition_text(required)
    )
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
    loops_by_role = [
        [loop.values for loop in results.loops if loop.point == point] for point in (DEFAULT, results.tuned)
    ]
    if not all(loops_by_role):
        return []
    rows = []
    for name, columns in WORST.items():
        quantity = QUANTITIES[name]
        worst = max if quantity.sense == "max" else min
        numbers = [
            [value for loop in loops for key in columns if (value := loop.get(key)) is not None]
            for loops in loops_by_role
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
    return element("span", plus(value, signed) + significant(value), class_="number")
