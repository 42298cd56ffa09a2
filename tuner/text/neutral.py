"""Texts of plants that are no vehicles: simulations in place of flights."""

import re

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
_WORD = re.compile(rf"\b({'|'.join(NEUTRAL)})\b", re.IGNORECASE)
_PART = re.compile(r"(<(?:pre|code|select)\b.*?</(?:pre|code|select)>|<[^>]*>)", re.DOTALL)
_TIP = re.compile(r'(?<=data-tip=")[^"]*')


def neutral(text: str) -> str:
    """Return a text with neutral words."""
    return _WORD.sub(_replacement, text)


def neutral_markup(markup: Markup) -> Markup:
    """Return markup with neutral words in its texts and tips."""
    parts = _PART.split(markup)
    return Markup("".join(_TIP.sub(_neutral_tip, part) if i % 2 else neutral(part) for i, part in enumerate(parts)))


def _neutral_tip(match: re.Match[str]) -> str:
    return neutral(match[0])


def _replacement(match: re.Match[str]) -> str:
    word = NEUTRAL[match[0].lower()]
    return word.capitalize() if match[0][0].isupper() else word
