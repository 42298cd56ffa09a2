"""Parts of sentences: lists, counted nouns, limits."""

from collections.abc import Iterable

from tuner.text.numbers import count, significant

NUMBER_WORDS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")


def listing(names: Iterable[str]) -> str:
    """Return "a", "a and b", "a, b and c"; "" for none."""
    *others, last = list(names) or [""]
    return f"{', '.join(others)} and {last}" if others else last


def counted(number: int, noun: str) -> str:
    """Return "no flights", "one flight", "three flights", "12 flights"."""
    word = NUMBER_WORDS[number] if number < len(NUMBER_WORDS) else count(number)
    return f"{word} {noun}{'' if number == 1 else 's'}"


def limit_text(limit: float, unit: str, sense: str = "most") -> str:
    """Return "at most 0.05 m", or "at least 0.05 m"."""
    return f"at {sense} {significant(limit)} {unit}".rstrip()
