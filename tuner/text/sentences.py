"""Parts of sentences: lists, counted nouns, limits."""

from collections.abc import Iterable, Sequence

from tuner.text.numbers import count, significant

NUMBER_WORDS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")


def listing(names: Iterable[str]) -> str:
    """Return "a", "a and b", "a, b and c"; "" for none."""
    *others, last = list(names) or [""]
    return f"{', '.join(others)} and {last}" if others else last


def first_texts(texts: Sequence[str], most: int) -> str:
    """Return the first of several texts, and the number of the others."""
    further = len(texts) - most
    return ", ".join(texts[:most]) + (f" and {further} more" if further > 0 else "")


def capitalized(text: str) -> str:
    """Return a text as a sentence, with a full stop."""
    return f"{text[:1].upper()}{text[1:]}."


def counted(number: int, noun: str) -> str:
    """Return "no flights", "one flight", "three flights", "12 flights"."""
    word = NUMBER_WORDS[number] if number < len(NUMBER_WORDS) else count(number)
    return f"{word} {noun}{'' if number == 1 else 's'}"


BOUNDS = {"min": "at least", "max": "at most"}
"""Senses of limits, as studies and documents write them, in sentences."""


def limit_text(limit: float, unit: str, sense: str = "max") -> str:
    """Return a limit in a sentence: "at most 0.05 m", or "at least 0.05 m"."""
    return f"{BOUNDS[sense]} {significant(limit)} {unit}".rstrip()


def bound_text(limit: float, sense: str = "max") -> str:
    """Return a limit in a table, with the word of the study: "max 0.05", or "min 35"."""
    return f"{sense} {significant(limit, 6)}"


# Relative difference of numbers below which they are the same.
SAME = 1e-9


def differing(pairs: Iterable[tuple[str, object, object]]) -> list[str]:
    """Return the pairs that differ, each as "NAME 'one' instead of 'other'"; numbers are alike within rounding."""
    return [
        f"{name} {value_text(one)} instead of {value_text(other)}"
        for name, one, other in pairs
        if not _alike(one, other)
    ]


def value_text(value: object) -> str:
    """Return a value of a controller: numbers with six digits."""
    return f"{value:.6g}" if isinstance(value, float) else repr(value)


def _alike(one: object, other: object) -> bool:
    if isinstance(one, float) and isinstance(other, float):
        return one == other or abs(one - other) <= SAME * abs(other)
    return one == other
