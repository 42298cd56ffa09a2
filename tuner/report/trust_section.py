"""Whether to believe it: search against held-out values, places on the front, how the search went, prices, sensitivity."""

from tuner.documents.parts import SampledValue, in_shown_units, is_level, row_in_degrees
from tuner.documents.summary import RelaxedLimit
from tuner.documents.tuning import TuningFolder
from tuner.report.choice_section import choice_section
from tuner.report.page import aid, wide
from tuner.report.words import loss_words, uncertainty_words
from tuner.text.markup import Markup, element, join, table
from tuner.text.numbers import count, estimate, per_cent, significant
from tuner.text.units import marked_up

MOST_NUMBERS = 4
"""Numbers of the vehicle that are shown of each objective."""
CHANCE = "no more than chance"


def trust_section(results: TuningFolder, charts: Markup) -> Markup:
    """Return the section without its heading; charts: search against held-out values and how the search went."""
    return join(
        (
            _guards(results),
            choice_section(results),
            charts,
            _losses(results),
            _saved(results),
            _prices(results),
            _uncertainty(results),
            _conflict(results),
            _sensitivity(results),
        )
    )


def _guards(results: TuningFolder) -> Markup:
    warnings = len(results.summary.warnings)
    if not warnings:
        return aid("The guards of the run raised no warning.")
    word = "one warning" if warnings == 1 else f"{count(warnings)} warnings"
    link = element("a", "at the top of this page", href="#warnings")
    return element("p", f"The guards of the run raised {word}, ", link, ".", class_="aid")


def _losses(results: TuningFolder) -> Markup:
    """Return what losses that were not seen could do, and the lost flights by name."""
    said = loss_words(results.summary)
    return element("ul", *[element("li", text) for text in said], class_="notes") if said else Markup()


def _saved(results: TuningFolder) -> Markup:
    """Return which search it was and how many flights requirements and races saved, where the summary knows."""
    summary = results.summary
    told = [
        f"{count(entry.flights)} flights of {count(entry.candidates)} candidates {why}"
        for entry, why in (
            (summary.screened, "that break a hard requirement"),
            (summary.raced, "whose race ended early"),
            (summary.settled, "whose place among the finalists was settled before"),
        )
        if entry is not None and entry.candidates
    ]
    flown = f"{count(summary.flights)} flights were made."
    saved = f" Saved: {', and '.join(told)}." if told else ""
    return aid(" ".join(filter(None, (summary.search, flown + saved))))


def _prices(results: TuningFolder) -> Markup:
    costs = [row_in_degrees(entry, "kept", "without") for entry in results.summary.costs]
    if not costs:
        return Markup()
    rows = [
        [
            element("code", entry.limit),
            element("code", entry.objective),
            marked_up(entry.unit),
            *[element("span", significant(value), class_="number") for value in (entry.kept, entry.without)],
        ]
        for entry in costs
    ]
    head = ("Limit", "Objective", "Unit", "Best with it", "Best without it")
    text = (
        "The best values that the search found, with each limit and without it; limits that cost nothing are left out."
    )
    notes = [element("li", text) for text in results.summary.remarks]
    return join(
        (
            element("h3", "What the limits cost"),
            aid(text),
            wide(table(head, rows, class_="stacked")),
            element("ul", *notes, class_="notes") if notes else Markup(),
        )
    )


def _uncertainty(results: TuningFolder) -> Markup:
    """Return what is lost because the vehicle is not known better, and what each of its numbers is worth."""
    costs = results.summary.uncertainty
    if not costs:
        return Markup()
    rows = [
        [
            element("code", cost.label),
            element("code", entry.name),
            _of_mean(entry.value, cost.mean, entry.told),
            element("span", per_cent(entry.share) if entry.shows else CHANCE, class_="number"),
        ]
        for cost in costs
        for entry in cost.numbers[:MOST_NUMBERS]
    ]
    text = (
        "Worth: by how much the mean of an objective would fall if the number were known when one of the finalists is chosen, "
        "from their held-out flights, each with a vehicle of its own. It tells of these finalists only: gains tuned to what is "
        "then known can gain more."
    )
    notes = [element("li", uncertainty_words(cost)) for cost in costs]
    return join(
        (
            element("h3", "What not knowing the vehicle costs"),
            aid(text),
            wide(table(("Objective", "Number", "Worth", "Share of the spread"), rows, class_="stacked")),
            element("ul", *notes, class_="notes"),
        )
    )


def _of_mean(value: float, mean: float, told: bool) -> Markup:
    return element("span", per_cent(value / abs(mean)) if told else CHANCE, class_="number")


def _conflict(results: TuningFolder) -> Markup:
    """Return the sets of limits that nobody kept together and what would let a candidate in."""
    conflict = results.summary.conflict
    if conflict is None:
        return Markup()
    sets = element("ul", *[element("li", " and ".join(some)) for some in conflict.sets], class_="notes")
    steps = [("one limit alone", entry) for entry in conflict.single]
    if conflict.common is not None:
        steps.append(("every limit a little", conflict.common))
    rows = [
        [
            words,
            f"{entry.candidate}, the default" if entry.default else entry.candidate,
            per_cent(entry.share) if entry.share <= 1.0 else f"{significant(entry.share, 3)} times the limit",
            element("span", "; ".join(_relaxed(limit) for limit in entry.limits)),
        ]
        for words, entry in steps
    ]
    head = ("Giving way", "Lets in", "Largest step", "Limits")
    parts = [element("h3", "Limits in conflict"), aid("No candidate kept these together:"), sets]
    return join([*parts, wide(table(head, rows, class_="stacked"))] if rows else parts)


def _relaxed(stored: RelaxedLimit) -> str:
    entry = in_shown_units(stored) if is_level(stored) else row_in_degrees(stored, "limit", "relaxed")
    return f"{entry.label} {significant(entry.limit)} → {significant(entry.relaxed)} {entry.unit}".rstrip()


def _sensitivity(results: TuningFolder) -> Markup:
    """Return how much of the spread of each objective each gain makes, where an analysis lies in the folder."""
    found = results.sensitivity
    if found is None and results.told:
        return Markup()
    if found is None:
        said = "No sensitivity analysis lies in this folder; tuner sensitivity makes one from the study."
        return aid(said)
    wanted = [row for row in found.indices if row.scale == "rank"] or found.indices
    outputs = list(dict.fromkeys(row.output for row in wanted))
    names = list(dict.fromkeys(row.variable for row in wanted))
    by_place = {(row.variable, row.output): row.total for row in wanted}
    rows = [[element("code", name), *[_index(by_place.get((name, output))) for output in outputs]] for name in names]
    text = (
        "Share of the spread of each quantity, over the whole search ranges, that vanishes when a gain is fixed (total Sobol "
        "index of ranks), with 95 % intervals: near 0 the gain does not matter."
    )
    return join(
        (
            element("h3", "Which gains matter"),
            aid(text),
            wide(table(["Gain", *outputs], rows, class_="stacked")),
        )
    )


def _index(entry: SampledValue | None) -> Markup:
    if entry is None:
        return Markup()
    value, interval = estimate(entry.value, entry.low, entry.high)
    return element("span", value, " ", element("small", interval, class_="interval"), class_="number")
