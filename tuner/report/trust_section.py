"""Whether to believe it: search against held-out values, places on the front, how the search went, prices, sensitivity."""

from typing import Any

from objectives.scales import DECIBEL
from tuner.documents.results import Results
from tuner.report.choice_section import choice_section
from tuner.report.page import aid, wide
from tuner.text.markup import Markup, element, join, table
from tuner.text.numbers import count, estimate, per_cent, significant
from tuner.text.units import in_degrees, in_shown_units, marked_up


def trust_section(results: Results, charts: Markup) -> Markup:
    """Return the section without its heading; charts: search against held-out values and how the search went."""
    return join(
        (
            _guards(results),
            choice_section(results),
            charts,
            _saved(results),
            _prices(results),
            _conflict(results),
            _sensitivity(results),
        )
    )


def _guards(results: Results) -> Markup:
    warnings = len(results.summary["warnings"])
    if not warnings:
        return aid("The guards of the run raised no warning.")
    word = "one warning" if warnings == 1 else f"{count(warnings)} warnings"
    link = element("a", "at the top of this page", href="#warnings")
    return element("p", f"The guards of the run raised {word}, ", link, ".", class_="aid")


def _saved(results: Results) -> Markup:
    """Return how many flights requirements and races saved, where the summary knows."""
    told = [
        f"{count(entry['flights'])} flights of {count(entry['candidates'])} candidates {why}"
        for key, why in (("screened", "that break a hard requirement"), ("raced", "whose race ended early"))
        if (entry := results.summary.get(key)) and entry["candidates"]
    ]
    flown = f"{count(results.summary['flights'])} flights were made."
    saved = f" Saved: {', and '.join(told)}." if told else ""
    return aid(flown + saved)


def _prices(results: Results) -> Markup:
    costs = results.summary.get("costs") or []
    if not costs:
        return Markup()
    rows = [
        [
            element("code", entry["limit"]),
            element("code", entry["objective"]),
            marked_up(in_degrees(entry["unit"]).unit),
            *[_shown(entry, key) for key in ("with", "without")],
        ]
        for entry in costs
    ]
    head = ["Limit", "Objective", "Unit", "Best with it", "Best without it"]
    text = (
        "The best values that the search found, with each limit and without it; limits that cost nothing are left out."
    )
    notes = [element("li", text) for text in results.summary.get("remarks", [])]
    return join(
        (
            element("h3", "What the limits cost"),
            aid(text),
            wide(table(head, rows, class_="stacked")),
            element("ul", *notes, class_="notes") if notes else Markup(),
        )
    )


def _shown(entry: dict[str, Any], key: str) -> Markup:
    return element("span", significant(entry[key] * in_degrees(entry["unit"]).factor), class_="number")


def _conflict(results: Results) -> Markup:
    """Return the sets of limits that nobody kept together and what would let a candidate in."""
    conflict = results.summary.get("conflict")
    if not conflict:
        return Markup()
    sets = element("ul", *[element("li", " and ".join(some)) for some in conflict["sets"]], class_="notes")
    steps = [("one limit alone", entry) for entry in conflict.get("single", [])]
    if conflict.get("common"):
        steps.append(("every limit a little", conflict["common"]))
    rows = [
        [
            words,
            f"{entry['candidate']}, the default" if entry.get("default") else entry["candidate"],
            per_cent(entry["share"]) if entry["share"] <= 1.0 else f"{significant(entry['share'], 3)} times the limit",
            element("span", "; ".join(_relaxed(limit) for limit in entry["limits"])),
        ]
        for words, entry in steps
    ]
    head = ["Giving way", "Lets in", "Largest step", "Limits"]
    parts = [element("h3", "Limits in conflict"), aid("No candidate kept these together:"), sets]
    return join([*parts, wide(table(head, rows, class_="stacked"))] if rows else parts)


def _relaxed(limit: dict[str, Any]) -> str:
    limit = in_shown_units(limit) if limit.get("shown_unit") == DECIBEL.unit else limit
    unit, factor = in_degrees(limit["unit"])
    values = [significant(limit[key] * factor) for key in ("limit", "relaxed")]
    return f"{limit['label']} {values[0]} → {values[1]} {unit}".rstrip()


def _sensitivity(results: Results) -> Markup:
    """Return how much of the spread of each objective each gain makes, where an analysis lies in the folder."""
    found = results.sensitivity
    if found is None:
        said = "No sensitivity analysis lies in this folder; tuner sensitivity makes one from the study."
        return aid(said)
    wanted = [row for row in found["indices"] if row["scale"] == "rank"] or found["indices"]
    outputs = list(dict.fromkeys(row["output"] for row in wanted))
    names = list(dict.fromkeys(row["variable"] for row in wanted))
    by_place = {(row["variable"], row["output"]): row["total"] for row in wanted}
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


def _index(entry: dict[str, float] | None) -> Markup:
    if entry is None:
        return Markup()
    value, interval = estimate(entry["value"], entry["low"], entry["high"])
    return element("span", value, " ", element("small", interval, class_="interval"), class_="number")
