"""ArduPilot's parameter file `.param`: one "NAME,VALUE" (Mission Planner) or "NAME VALUE" (MAVProxy) a line; the columns of
QGroundControl are read as well.

Names are at most 16 of A-Z, 0-9 and _. They changed between Copter 4.6 and 4.7, and a vehicle ignores in silence what it does not
know, so a file belongs to a version.
"""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from plant.errors import InputError
from tuner.exchange.autopilot.parameter_text import (
    as_bytes,
    check_stack,
    enter,
    positional,
    read_lines,
    read_number,
    single,
)

WHAT = "a .param file of ArduPilot Copter"
SEPARATORS = {"comma": ",", "blank": " "}
NAME = re.compile(r"[A-Z][A-Z0-9_]{0,15}")
# The five columns of QGroundControl: vehicle, component, name, value, type.
COLUMNS = re.compile(r"\d{1,3}\t\d{1,3}\t([^\s,]+)\t([^\s,#]+)\t\d{1,2}")
# A value, then what some clients append: a comment, or the "@READONLY" of a full download.
LINE = re.compile(r"([^\s,=]+)[\s,=]+([^\s,#]+)\s*(#.*|@.*)?")


def write_param(values: Mapping[str, float], separator: str, comments: Sequence[str]) -> bytes:
    """Return the content of a file; separator: a key of SEPARATORS."""
    mark = SEPARATORS[separator]
    rows = [f"{name}{mark}{positional(value)}" for name, value in values.items()]
    return as_bytes([*(f"# {comment}" for comment in comments), *rows])


def read_param(file: Path) -> dict[str, float]:
    """Return the parameters of a file; raises InputError naming file and parameter."""
    check_stack(file, WHAT, "ArduPilot")
    values: dict[str, float] = {}
    for number, line in enumerate(read_lines(file, WHAT), start=1):
        text = line.strip()
        if not text or text.startswith(("#", "//")):
            continue
        parts = COLUMNS.fullmatch(text) or LINE.fullmatch(text)
        if parts is None or not NAME.fullmatch(parts[1]):
            message = f"must be a name of at most 16 of A-Z, 0-9, _, a comma or blanks, and a number; give {WHAT}"
            raise InputError(message, file=file, key=f"line {number}")
        enter(values, parts[1], single(read_number(parts[2], parts[1], file)), file)
    if not values:
        raise InputError(f"holds no parameter; give {WHAT}", file=file)
    return values
