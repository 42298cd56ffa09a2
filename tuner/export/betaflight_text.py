"""Betaflight's command line as a file: `set name = value`, within a PID profile, as `diff` and `dump` print it.

The firmware answers a wrong name or value with a line that begins with ###ERROR and goes on: whoever loads a file looks for ###.
"""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from plant.errors import InputError, shortened
from tuner.export.parameter_text import as_bytes, read_lines

WHAT = "what Betaflight's command line prints for 'diff all' or 'dump all'"
SETTING = re.compile(r"set\s+([a-z0-9_]+)\s*=\s*(\S.*?)\s*")
PROFILE = re.compile(r"profile\s+([0-9])")
PROFILES = 4


def write_cli(values: Mapping[str, str], profile: int, comments: Sequence[str]) -> bytes:
    """Return the content of a file that sets values in one PID profile and saves them."""
    body = [f"set {name} = {value}" for name, value in values.items()]
    return as_bytes(
        [*(f"# {comment}" for comment in comments), "batch start", f"profile {profile}", *body, "batch end", "save"]
    )


def read_cli(file: Path, profile: int) -> dict[str, str]:
    """Return the settings that hold in a PID profile; raises InputError naming file and setting.

    Settings before the first `profile` hold in every profile; those of a profile hold until the next one.
    """
    values: dict[str, str] = {}
    inside: int | None = None
    for line in read_lines(file, WHAT):
        text = line.strip()
        if found := PROFILE.fullmatch(text):
            inside = int(found[1])
        elif text.startswith("rateprofile"):
            inside = None
        elif (found := SETTING.fullmatch(text)) and inside in (None, profile):
            _enter(values, found[1], found[2], file)
        elif text.startswith("###"):
            raise InputError(f"holds the error '{shortened(text)}' of the firmware; give {WHAT}", file=file)
    if not values:
        raise InputError(f"holds no setting of profile {profile}; give {WHAT}", file=file)
    return values


def whole(text: str, name: str, file: Path) -> float:
    """Return a setting as a whole number; raises InputError naming it."""
    if not re.fullmatch(r"[+-]?\d{1,9}", text):
        raise InputError(f"given '{shortened(text)}'; this must be a whole number", file=file, key=name)
    return float(int(text))


def _enter(values: dict[str, str], name: str, value: str, file: Path) -> None:
    if values.setdefault(name, value) != value:
        message = f"given twice, as {shortened(values[name])} and as {shortened(value)}; leave one out"
        raise InputError(message, file=file, key=name)
