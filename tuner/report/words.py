"""Laws, gaps, losses and the search in plain words."""

from plant.law_registry import LAWS
from tuner.documents.parts import Estimate
from tuner.documents.resolved import Resolved
from tuner.documents.summary import SelectionValues, Summary, UncertaintyCost
from tuner.text.numbers import count, per_cent


def law_title(name: str) -> str:
    """Return the title of a law."""
    return LAWS[name].title if name in LAWS else name


def laws_of(resolved: Resolved) -> list[tuple[str, str]]:
    """Return the law of each loop: pairs of law and loop."""
    controller = resolved.controller
    if controller is None:
        return [(channel.law, channel.name) for channel in resolved.channel]
    return [(controller.position, "position"), (controller.attitude, "attitude")]


def gap_words(picked: SelectionValues, gap: Estimate) -> str:
    """Return the optimism of the search in words, from the gap between held-out and search value.

    picked: `picked_on` of summary.json; a folder of an earlier version holds no `lost_in_search`.
    """
    lost = picked.lost_in_search if "lost_in_search" in picked.model_fields_set else 0.0
    if lost is None:
        return "it was not flown in the search, whose value is that of flights that failed at once"
    if lost > 0.0:
        return f"it lost {per_cent(lost)} of its flights in the search, and a lost flight costs more than any other"
    if gap.low is not None and gap.low > 0.0:
        return "the search was optimistic"
    return (
        "the search was pessimistic"
        if gap.high is not None and gap.high < 0.0
        else "no significant optimistic bias of the search"
    )


def loss_words(summary: Summary) -> list[str]:
    """Return the bound on unseen losses, and the failed flights by name."""
    unseen = [] if summary.unseen is None else [summary.unseen.words]
    return [*unseen, *[f"Failed: {entry.words}." for entry in summary.lost_flights]]


def search_texts(summary: Summary) -> list[str]:
    """Return the search, and the flights that requirements, races and settled ranks saved, in sentences."""
    skipped = (
        (summary.screened, "candidates", "hard requirement violated"),
        (summary.raced, "candidates", "race decided early"),
        (summary.settled, "finalists", "rank already decided"),
    )
    flights = [
        f"{count(part.flights)} flights skipped ({count(part.candidates)} {noun}, {why})."
        for part, noun, why in skipped
        if part is not None and part.candidates
    ]
    return [*filter(None, [summary.search]), *flights]


def uncertainty_words(row: UncertaintyCost) -> str:
    """Return the cost of uncertainty of an objective, and the number to measure next."""
    first, mean = row.next, abs(row.mean)
    spread = (
        f"{first.name} explains {per_cent(first.share)} of the spread"
        if first.shows
        else "no number shows in the spread"
    )
    if not row.is_significant:
        return (
            f"{row.label}: knowing the vehicle better would change no choice among {row.finalists} finalists; {spread}."
        )
    verdict = (
        f"it alone is worth {per_cent(first.value / mean)}" if first.is_significant else "none is worth much alone"
    )
    return (
        f"{row.label}: not knowing the vehicle better costs {per_cent((row.mean - row.mean_if_known) / mean)} of its mean among "
        f"{row.finalists} finalists. Measure {first.name} next: {verdict}; {spread}."
    )
