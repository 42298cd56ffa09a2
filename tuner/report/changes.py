"""A difference to the default in a headline: per cent of its value, or in units where that value is next to nothing."""

from tuner.documents.parts import Estimate
from tuner.text.numbers import estimate, fixed
from tuner.text.units import plain

MAX_SHARE = 300.0
"""Largest change in per cent of the default's value that is shown as such."""


def relative_change(default: Estimate, difference: Estimate) -> tuple[str, str] | None:
    """Return a difference and its interval in per cent: None without meaning.

    That is where the default may as well be 0, where it changes several times over, and where an end of the interval is a
    fall by more than all of it.
    """
    value, (middle, low, high) = default.value, difference
    if not value or value < 0.0 or middle is None or low is None or high is None:
        return None
    shares = [100.0 * part / value for part in (middle, low, high)]
    if (default.low is not None and default.low <= 0.0) or max(shares) > MAX_SHARE or min(shares) < -100.0:
        return None
    decimals = 0 if shares[2] - shares[1] > 2.0 else 1
    number, bottom, top = (fixed(share, decimals, signed=True) for share in shares)
    return f"{number} %", f"[{bottom}, {top}]"


def headline_change(default: Estimate, difference: Estimate, unit: str) -> str:
    """Return a difference with its interval, in per cent or units."""
    relative = relative_change(default, difference)
    if relative is not None:
        return " ".join(relative)
    number, ends = estimate(*difference, signed=True)
    return f"{number} {ends}" if unit in ("", "1") else f"{number} {plain(unit)} {ends}"
