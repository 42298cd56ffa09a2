"""SD card logs (uSD deck) of a Crazyflie, of the event `fixedFrequency`.

Little-endian: byte 0xBC; u16 version, u16 number of event types; each with u16 id, its name ended by a zero byte, u16 number of
variables and their texts `name(c)`, where c is a letter of Python's struct; then records of u16 id, time stamp (version 1: u32 in
ms, version 2: u64 in us) and the variables; at last the CRC-32 of all before.
"""

from typing import NamedTuple
from zlib import crc32

import numpy as np

from plant.errors import InputError
from tuner.extensions.logs.flight_log import STANDARD_GRAVITY, Array, FlightLog

MAGIC = b"\xbc"
EVENT = "fixedFrequency"
STAMPS = {1: ("<u4", 1e-3), 2: ("<u8", 1e-6)}
"""Version -> type of a time stamp, and its unit [s]."""
LETTERS = "bBhHiIqQfd"
FULL = 65535.0
# The deck numbers its motors clockwise from front right.
MOTORS = ("motor.m4", "motor.m1", "motor.m3", "motor.m2")
MAX_EVENTS, MAX_VARIABLES, LONGEST_NAME = 64, 256, 128


class _Event(NamedTuple):
    number: int
    name: str
    variables: tuple[tuple[str, str], ...]


def is_crazyflie(content: bytes) -> bool:
    """Return true for a file that begins as such a log."""
    return content[:1] == MAGIC and len(content) > 5 and int.from_bytes(content[1:3], "little") in STAMPS


def read_crazyflie(content: bytes, name: str, digest: str) -> FlightLog:
    """Return the log; raises InputError where it is cut off, damaged or lacks a variable."""
    version = int.from_bytes(content[1:3], "little")
    is_whole = crc32(content[:-4]) == int.from_bytes(content[-4:], "little")
    notes = () if is_whole else ("its check sum is wrong: the end may be missing or damaged",)
    events, start = _head(content, name)
    stamp, unit = STAMPS[version]
    table = _table(content, start, events, stamp, name)
    acceleration, gyro = (_columns(table, [f"{kind}.{axis}" for axis in "xyz"], name) for kind in ("acc", "gyro"))
    return FlightLog(
        name,
        "Crazyflie SD card",
        digest,
        table["time"].astype(float) * unit,
        np.radians(gyro),
        STANDARD_GRAVITY * acceleration,
        _columns(table, MOTORS, name) / FULL,
        notes,
    )


def _head(content: bytes, name: str) -> tuple[dict[int, _Event], int]:
    """Return the events by their number and where the records begin."""
    place, events = 5, {}
    for _ in range(_bounded(int.from_bytes(content[3:5], "little"), MAX_EVENTS, "event types", name)):
        number, place = _uint16(content, place, name)
        title, place = _word(content, place, name)
        count, place = _uint16(content, place, name)
        variables = []
        for _ in range(_bounded(count, MAX_VARIABLES, "variables", name)):
            text, place = _word(content, place, name)
            variables.append(_variable(text, name))
        events[number] = _Event(number, title, tuple(variables))
    return events, place


def _bounded(count: int, most: int, what: str, name: str) -> int:
    if count > most:
        raise InputError(f"says that it has {count:,} {what}; a log has at most {most}: it is damaged", file=name)
    return count


def _uint16(content: bytes, place: int, name: str) -> tuple[int, int]:
    if place + 2 > len(content):
        raise InputError("ends within its head; copy it from the card again", file=name)
    return int.from_bytes(content[place : place + 2], "little"), place + 2


def _word(content: bytes, place: int, name: str) -> tuple[str, int]:
    end = content.find(b"\0", place, place + LONGEST_NAME)
    if end < 0:
        raise InputError("ends within its head or holds a name without end; copy it from the card again", file=name)
    return content[place:end].decode("ascii", "replace"), end + 1


def _variable(text: str, name: str) -> tuple[str, str]:
    letter = text[-2:-1]
    if not (text.endswith(")") and text[-3:-2] == "(" and letter and letter in LETTERS):
        raise InputError(f"holds a variable '{text}', which has no type such as 'gyro.x(f)'; it is damaged", file=name)
    return text[:-3], f"<{letter}"


def _table(content: bytes, start: int, events: dict[int, _Event], stamp: str, name: str) -> np.ndarray:
    """Return the records of the event; others between them are stepped over one by one."""
    wanted = next((event for event in events.values() if event.name == EVENT), None)
    if wanted is None:
        given = ", ".join(event.name for event in events.values()) or "none"
        raise InputError(f"has no event '{EVENT}' (given: {given}); log at a fixed frequency", file=name)
    if len({variable for variable, _ in wanted.variables} | {"id", "time"}) != len(wanted.variables) + 2:
        raise InputError("names a variable twice; it is damaged", file=name)
    kinds = {event.number: np.dtype([("id", "<u2"), ("time", stamp), *event.variables]) for event in events.values()}
    body = content[start : max(len(content) - 4, start)]
    if len(kinds) == 1:
        kind = kinds[wanted.number]
        table = np.frombuffer(body, kind, len(body) // kind.itemsize)
        return table[table["id"] == wanted.number]
    parts, place = [], 0
    while place + 2 <= len(body):
        kind = kinds.get(int.from_bytes(body[place : place + 2], "little"))
        if kind is None or place + kind.itemsize > len(body):
            break
        if kind is kinds[wanted.number]:
            parts.append(body[place : place + kind.itemsize])
        place += kind.itemsize
    return np.frombuffer(b"".join(parts), kinds[wanted.number])


def _columns(table: np.ndarray, variables: list[str] | tuple[str, ...], name: str) -> Array:
    missing = [variable for variable in variables if variable not in (table.dtype.names or ())]
    if missing:
        raise InputError(f"lacks {', '.join(missing)}; log them too: acc, gyro and motor.m1 to m4", file=name)
    return np.column_stack([table[variable].astype(float) for variable in variables])
