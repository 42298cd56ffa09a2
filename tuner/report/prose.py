"""Sentences and their parts: lists, counts, laws, limits, and what a gap says."""

from plant.laws import LAWS
from tuner.documents.parts import Estimate
from tuner.documents.summary import PickedOn
from tuner.text.numbers import count, per_cent, significant

NUMBER_WORDS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")


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


def gap_words(picked: PickedOn, gap: Estimate) -> str:
    """Return what the gap between held-out and search value of the recommended point says of the search.

    picked: `picked_on` of summary.json; a folder of an earlier version holds no `lost_in_search`.
    """
    lost = picked.lost_in_search if "lost_in_search" in picked.model_fields_set else 0.0
    if lost is None:
        return "it was not flown in the search, whose value is that of flights that failed at once"
    if lost > 0.0:
        return f"it lost {per_cent(lost)} of its flights in the search, and a lost flight costs more than any other"
    if (gap.low or 0.0) > 0.0:
        return "the search was optimistic"
    return "the search was pessimistic" if (gap.high or 0.0) < 0.0 else "no optimism of the search to be told"


def limit_text(limit: float, unit: str, sense: str = "most") -> str:
    """Return "at most 0.05 m", or "at least 0.05 m"."""
    return f"at {sense} {significant(limit)} {unit}".rstrip()
