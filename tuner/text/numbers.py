"""Numbers as text: as many digits as the interval around a number supports, no more.

Two significant digits of the interval's width are shown, of the value and of both ends alike: 0.43217 in [0.4112,
0.4507] reads "0.432 [0.411, 0.451]". Minus is U+2212, groups of three are set apart by U+202F from five digits on.
"""

from math import floor, isfinite, log10

MISSING = "–"
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
# Beyond these a fixed-point number is mostly zeros.
_MAX_DECIMALS, _LARGEST = 5, 1e6


def estimate(value: float | None, low: float | None, high: float | None, signed: bool = False) -> tuple[str, str]:
    """Return value and "[low, high]"; signed: with a plus on positive numbers. Missing numbers are dashes."""
    if value is None or low is None or high is None or not all(isfinite(v) for v in (value, low, high)):
        return (significant(value), MISSING)
    decimals, power = _layout(value, low, high)
    scale, tail = 10.0**-power, _times_ten(power)
    middle, bottom, top = (fixed(v * scale, decimals, signed) for v in (value, low, high))
    return middle + tail, f"[{bottom}, {top}]{tail}"


def rounded_to(value: float | None, width: float) -> str:
    """Return a number with the digits that its interval's width supports."""
    if value is None or not isfinite(value) or not isfinite(width):
        return significant(value)
    decimals, power = _layout(value, value, value + abs(width))
    return fixed(value * 10.0**-power, decimals) + _times_ten(power)


def significant(value: float | None, digits: int = 4) -> str:
    """Return a number to so many significant digits, without trailing zeros."""
    if value is None or not isfinite(value):
        return MISSING
    if value == 0.0:
        return "0"
    power = floor(log10(abs(value)))
    if -4 <= power < 6:
        text = fixed(value, max(digits - 1 - power, 0))
        return text.rstrip("0").rstrip(".") if "." in text else text
    return significant(value / 10.0**power, digits) + _times_ten(power)


def fixed(value: float, decimals: int, signed: bool = False) -> str:
    """Return a number to so many decimals."""
    value = round(value, decimals) + 0.0
    text = f"{plus(value, signed)}{value:,.{decimals}f}"
    return text.replace("-", "−").replace(",", "\u202f" if abs(value) >= 1e4 else "")


def plus(value: float, signed: bool = True) -> str:
    """Return the sign of a positive number, if signed; a negative one has its own."""
    return "+" if signed and value > 0.0 else ""


def count(value: float) -> str:
    """Return a whole number."""
    return fixed(value, 0)


def ordinal(number: int) -> str:
    """Return the ordinal before a superlative: "2nd ", "13th "; nothing for the first."""
    ending = "th" if number % 100 in (11, 12, 13) else {1: "st", 2: "nd", 3: "rd"}.get(number % 10, "th")
    return "" if number == 1 else f"{number:,}{ending} "


def per_cent(share: float | None) -> str:
    """Return a share as a percentage, "38 %"; below ten per cent with one decimal."""
    if share is None or not isfinite(share):
        return MISSING
    value = 100.0 * share
    return f"{fixed(value, 1 if 0.0 < abs(value) < 9.95 else 0)} %"


def duration(seconds: float) -> str:
    """Return a time span in the units a person would use: "0.84 s", "42 s", "4 min 12 s", "2 h 5 min"."""
    if seconds < 9.95:
        return f"{significant(seconds, 2)} s"
    total = round(seconds)
    if total < 60:
        return f"{total} s"
    if total < 3600:
        return f"{total // 60} min {total % 60} s"
    return f"{total // 3600} h {total % 3600 // 60} min"


def _layout(value: float, low: float, high: float) -> tuple[int, int]:
    """Return decimals and power of ten of a value and its interval."""
    largest = max(abs(value), abs(low), abs(high))
    if largest == 0.0:
        return 0, 0
    top = floor(log10(largest))
    width = high - low
    # An interval without width supports any number of digits; four are enough to compare.
    finest = floor(log10(width)) - 1 if width > 0.0 else top - 3
    if -finest > _MAX_DECIMALS or largest >= _LARGEST:
        return max(top - finest, 0), top
    return max(-finest, 0), 0


def _times_ten(power: int) -> str:
    return f" × 10{str(power).translate(_RAISED)}" if power else ""
