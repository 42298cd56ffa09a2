"""Texts of plants that are no vehicles: simulations in place of flights."""

import re
from collections.abc import Iterable
from html import escape

from tuner.text.markup import Markup

NEUTRAL = {
    "in the same air": "under the same disturbance",
    "flights": "simulations",
    "flight": "simulation",
    "flown": "simulated",
    "flew": "ran",
    "airframes": "plants",
    "airframe": "plant",
    "vehicle": "plant",
}
"""Word of vehicles -> neutral word."""
_PART = re.compile(r"(<(?:pre|code|select)\b.*?</(?:pre|code|select)>|<[^>]*>)", re.DOTALL)
_TIP = re.compile(r'(?<=data-tip=")[^"]*')


class Neutral:
    """Replacement of words of vehicles by neutral ones; names that the user gave stay as they are."""

    def __init__(self, names: Iterable[str] = ()) -> None:
        words = rf"\b(?P<word>{'|'.join(NEUTRAL)})\b"
        inner = re.compile(words, re.IGNORECASE)
        spared = {form for name in names if inner.search(name) for form in (name, escape(name))}
        # The longest first: one name may begin another.
        fixed = [rf"(?-i:(?<!\w){re.escape(name)}(?!\w))" for name in sorted(spared, key=len, reverse=True)]
        self._pattern = re.compile("|".join([*fixed, words]), re.IGNORECASE)

    def text(self, text: str) -> str:
        """Return a text with neutral words."""
        return self._pattern.sub(_replacement, text)

    def markup(self, markup: Markup) -> Markup:
        """Return markup with neutral words in its texts and tips."""
        parts = _PART.split(markup)
        return Markup("".join(_TIP.sub(self._tip, part) if i % 2 else self.text(part) for i, part in enumerate(parts)))

    def _tip(self, match: re.Match[str]) -> str:
        return self.text(match[0])


def _replacement(match: re.Match[str]) -> str:
    if match["word"] is None:
        return match[0]
    word = NEUTRAL[match[0].lower()]
    return word.capitalize() if match[0][0].isupper() else word
