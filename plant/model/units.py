"""Units of plants of the user's own, made from those that the plant's file gives."""

import re


def quotient(unit: str, by: str) -> str:
    """Return one unit over another: V/rad of V and rad, 1/s of rad/s and rad."""
    if by == "1":
        return unit
    if unit == by or unit.startswith(f"{by}/"):
        return "1" + unit.removeprefix(by)
    return f"{unit}/({by})" if re.search("[ /]", by) else f"{unit}/{by}"


def per_time(unit: str) -> str:
    """Return the unit of the derivative: rad/s of rad, m/s2 of m/s."""
    match = re.fullmatch(r"(.*)/s(\d?)", unit)
    return f"{match[1]}/s{int(match[2] or 1) + 1}" if match else f"{unit}/s"


def times_time(unit: str) -> str:
    """Return the unit of the integral: V s/rad of V/rad, m of m/s, s of 1."""
    match = re.fullmatch(r"(.*)/s(\d?)", unit)
    if match:
        power = int(match[2] or 1) - 1
        return match[1] + (f"/s{power if power > 1 else ''}" if power else "")
    above, slash, below = unit.partition("/")
    return ("s" if above == "1" else f"{above} s") + slash + below


def gain_unit(command: str, output: str, integrals: int) -> str:
    """Return the unit of a gain from an error to a command behind so many integrals over time, -1 for a derivative."""
    unit = quotient(command, output)
    return {-1: times_time, 0: str, 1: per_time}[integrals](unit)
