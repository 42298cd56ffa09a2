"""Whether to believe it: search against held-out values, places on the front, how the search went, prices, sensitivity."""

from tuner.documents.obstacles import RelaxedLimit
from tuner.documents.parts import on_page, row_in_degrees
from tuner.documents.tuning import TuningFolder
from tuner.extension import objects
from tuner.report.charts.web import term
from tuner.report.choice_section import choice_section
from tuner.report.labels import in_plain_words, names_of
from tuner.report.page import aid, wide
from tuner.report.words import loss_words, search_texts, uncertainty_words
from tuner.text.markup import Markup, element, join, table
from tuner.text.numbers import count, per_cent, significant
from tuner.text.units import marked_up

MAX_NUMBERS = 4
"""Parameters of the vehicle that are shown of each objective."""
CHANCE = "not significant"


def trust_section(results: TuningFolder, charts: Markup) -> Markup:
    """Return the section without its heading.

    Args:
        results: Results of the run.
        charts: Search against held-out values, and how the search went.
    """
    return join(
        (
            _guards(results),
            choice_section(results),
            charts,
            _losses(results),
            *_added("loss_sections", results),
            aid(" ".join((f"{count(results.document.flights)} flights were made.", *search_texts(results.document)))),
            _prices(results),
            _uncertainty(results),
            _conflict(results),
            *_added("sections", results),
        )
    )


def _added(part: str, results: TuningFolder) -> list[Markup]:
    """Return the sections in a part of all records."""
    return [section(results) for section in objects(part).values()]


def _guards(results: TuningFolder) -> Markup:
    warnings = len(results.document.warnings)
    if not warnings:
        return aid("The checks of the run raised no warning.")
    word = "one warning" if warnings == 1 else f"{count(warnings)} warnings"
    link = element("a", "at the top of this page", href="#warnings")
    return element("p", f"The checks of the run raised {word}, ", link, ".", class_="aid")


def _losses(results: TuningFolder) -> Markup:
    """Return the bound on unseen losses, and the failed flights by name."""
    sentences = [in_plain_words(text, names_of(results)) for text in loss_words(results.document)]
    return element("ul", *[element("li", text) for text in sentences], class_="notes") if sentences else Markup()


def _prices(results: TuningFolder) -> Markup:
    costs = [row_in_degrees(entry, "with_limit", "without") for entry in results.document.costs]
    names = names_of(results)
    if not costs:
        return Markup()
    rows = [
        [
            term(names.get(entry.limit, entry.limit), entry.limit),
            term(names.get(entry.objective, entry.objective), entry.objective),
            marked_up(entry.unit),
            *[element("span", significant(value), class_="number") for value in (entry.with_limit, entry.without)],
        ]
        for entry in costs
    ]
    head = ("Limit", "Objective", "Unit", "Best with the limit", "Best without")
    text = "Best values of the search with and without each limit; limits without cost are omitted."
    notes = [element("li", in_plain_words(text, names)) for text in results.document.remarks]
    return join(
        (
            element("h3", "Cost of the limits"),
            aid(text),
            wide(table(head, rows, class_="stacked")),
            element("ul", *notes, class_="notes") if notes else Markup(),
        )
    )


def _uncertainty(results: TuningFolder) -> Markup:
    """Return the cost of uncertainty, and the value of each of the vehicle's numbers."""
    costs, names = results.document.uncertainty, names_of(results)
    if not costs:
        return Markup()
    rows = [
        [
            term(names.get(cost.label, cost.label), cost.label),
            element("code", entry.name),
            _of_mean(entry.value, cost.mean, entry.is_significant),
            element("span", per_cent(entry.share) if entry.shows else CHANCE, class_="number"),
        ]
        for cost in costs
        for entry in cost.numbers[:MAX_NUMBERS]
    ]
    text = (
        "Decrease of the mean of an objective if the parameter were known when a finalist is selected, from held-out flights "
        "with sampled vehicles. It holds for these finalists only: gains tuned to the known value can improve further."
    )
    notes = [element("li", in_plain_words(uncertainty_words(cost), names)) for cost in costs]
    return join(
        (
            element("h3", "Value of knowing the vehicle"),
            aid(text),
            wide(
                table(("Objective", "Parameter", "Value of information", "Share of variance"), rows, class_="stacked")
            ),
            element("ul", *notes, class_="notes"),
        )
    )


def _of_mean(value: float, mean: float, is_significant: bool) -> Markup:
    return element("span", per_cent(value / abs(mean)) if is_significant else CHANCE, class_="number")


def _conflict(results: TuningFolder) -> Markup:
    """Return conflicting sets of limits, and relaxations that admit a candidate."""
    conflict = results.document.conflict
    if conflict is None:
        return Markup()
    sets = element("ul", *[element("li", " and ".join(some)) for some in conflict.sets], class_="notes")
    steps = [("one limit", entry) for entry in conflict.single]
    if conflict.common is not None:
        steps.append(("all limits", conflict.common))
    rows = [
        [
            words,
            f"{entry.candidate}, the default" if entry.default else entry.candidate,
            per_cent(entry.share) if entry.share <= 1.0 else f"{significant(entry.share, 3)} times the limit",
            element("span", "; ".join(_relaxed(limit) for limit in entry.limits)),
        ]
        for words, entry in steps
    ]
    head = ("Relaxed", "Feasible then", "Largest relaxation", "Limits")
    parts = [element("h3", "Limits in conflict"), aid("No candidate satisfies these together:"), sets]
    return join([*parts, wide(table(head, rows, class_="stacked"))] if rows else parts)


def _relaxed(stored: RelaxedLimit) -> str:
    entry = on_page(stored, "limit", "relaxed")
    return f"{entry.label} {significant(entry.limit)} → {significant(entry.relaxed)} {entry.unit}".rstrip()
