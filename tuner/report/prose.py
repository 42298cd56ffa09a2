"""The report's opening paragraph and its key figures, in plain words."""

from typing import Any

from plant.laws import LAWS
from tuner.documents.results import DEFAULT, Results
from tuner.text.markup import Markup, element, join
from tuner.text.numbers import count, duration, per_cent, significant

NUMBER_WORDS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")


def paragraph(results: Results) -> Markup:
    """Return what was flown, on what, with which laws, what is recommended and why, and how well that was checked."""
    return join((_flown(results), _searched(results), _recommended(results), _checked(results)), " ")


def key_figures(results: Results) -> list[tuple[str, str]]:
    """Return the numbers at the top of the page, name and value."""
    summary = results.summary
    return [
        ("Recommended point", results.tuned if results.feasible else "none"),
        ("Flights", count(summary["flights"])),
        ("Candidates", count(len(results.candidates.number))),
        ("Held-out scenarios", count(summary["held_out"])),
        ("Points on the front", count(summary["front_size"])),
        ("Wall time", duration(summary["wall_seconds"])),
    ]


def law_title(name: str) -> str:
    """Return what a law is called in full."""
    return LAWS[name].title if name in LAWS else name


def listing(names: list[str]) -> str:
    """Return "a", "a and b", "a, b and c"."""
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def counted(number: int, noun: str) -> str:
    """Return "no flights", "one flight", "three flights", "12 flights"."""
    word = NUMBER_WORDS[number] if number < len(NUMBER_WORDS) else count(number)
    return f"{word} {noun}{'' if number == 1 else 's'}"


def _flown(results: Results) -> Markup:
    airframe, controller = results.resolved["airframe"], results.resolved["controller"]
    air = [entry["scenario"] for entry in results.summary["air"]]
    where = f"in {counted(len(air), 'scenario')} ({listing(air)})" if air else "in simulated air"
    laws = [f"{law_title(controller[loop])} on {loop}" for loop in ("position", "attitude")]
    name = airframe.get("title") or airframe["name"]
    flights = element("strong", f"{count(results.summary['flights'])} simulated flights")
    return join(("The ", element("strong", name), " made ", flights, f" {where}, with {listing(laws)}."))


def _searched(results: Results) -> str:
    points = sum(role != DEFAULT for role in results.front.roles)
    return (
        f"The search ({results.resolved['search']['algorithm']}) tried {count(len(results.candidates.number))} sets of "
        f"gains over {counted(len(results.history.generation), 'generation')}; the default gains and "
        f"{counted(points, 'finalist')} were then flown again on {count(results.summary['held_out'])} held-out "
        "scenarios that the search had never seen."
    )


def _recommended(results: Results) -> Markup:
    point, why = results.tuned, results.summary["pick"]["why"].strip().rstrip(".")
    if not results.feasible:
        return join((element("strong", "Nothing is recommended"), f"; {point} comes nearest and is shown."))
    # Reasons are fragments ("it lies deepest ...") or sentences of their own.
    reason = f" is recommended because {why}." if why[:1].islower() else f" is recommended. {why}."
    if point == DEFAULT:
        return join((element("strong", "The default gains"), f" remain the recommendation: {why}."))
    return join(("Point ", element("strong", point), reason))


def _checked(results: Results) -> str:
    verdicts = [quantity.verdict for quantity in results.objectives]
    parts = [
        f"{word} in {listing([entry.label for entry in results.objectives if entry.verdict == verdict])}"
        for verdict, word in (("better", "better"), ("worse", "worse"))
        if verdict in verdicts
    ]
    unclear = verdicts.count("no clear difference")
    if unclear:
        parts.append(f"not clearly different in {counted(unclear, 'objective')}")
    compared = f"On scenarios that had no part in the choice it is {listing(parts)}." if parts else ""
    limited = [*results.constraints, *results.requirements]
    broken = [entry.label for entry in limited if entry.verdict == "broken"]
    if broken:
        return f"{compared} It breaks {listing(broken)}."
    kept = [(len(results.constraints), "constraint"), (len(results.requirements), "requirement")]
    return f"{compared} It keeps {listing([_all_of(*entry) for entry in kept if entry[0]])}." if limited else compared


def _all_of(number: int, noun: str) -> str:
    return {1: f"the {noun}", 2: f"both {noun}s"}.get(number, f"all {counted(number, noun)}")


def gap_words(picked: dict[str, Any], gap: dict[str, float]) -> str:
    """Return what the gap between held-out and search value of the recommended point says of the search.

    picked: `picked_on` of summary.json; a folder of an earlier version holds no `lost_in_search`.
    """
    lost = picked.get("lost_in_search", 0.0)
    if lost is None:
        return "it was not flown in the search, whose value is that of flights that failed at once"
    if lost > 0.0:
        return f"it lost {per_cent(lost)} of its flights in the search, and a lost flight costs more than any other"
    if gap["low"] > 0.0:
        return "the search was optimistic"
    return "the search was pessimistic" if gap["high"] < 0.0 else "no optimism of the search to be told"


def limit_text(limit: float, unit: str, sense: str = "most") -> str:
    """Return "at most 0.05 m", or "at least 0.05 m"."""
    return f"at {sense} {significant(limit)} {unit}".rstrip()
