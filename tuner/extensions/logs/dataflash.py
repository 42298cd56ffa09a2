"""Logs of ArduPilot (DataFlash, .bin).

Messages begin with A3 95 and a type; those of type 80 describe the others: type, length, name, a letter for each field, and the
fields' names. Read here and not by pymavlink, which prints a line for every byte that it cannot use.
"""

from typing import NamedTuple

import numpy as np

from plant.errors import InputError
from tuner.extensions.logs.autopilot import MOTORS, joined
from tuner.extensions.logs.flight_log import Array, FlightLog

HEAD, FORMAT, FORMAT_LENGTH = b"\xa3\x95", 0x80, 89
MAGIC = HEAD + bytes([FORMAT])
LETTERS = {
    "a": "V64", "b": "<i1", "B": "<u1", "h": "<i2", "H": "<u2", "i": "<i4", "I": "<u4", "f": "<f4", "d": "<f8", "g": "<f2",
    "n": "S4",
    "N": "S16", "Z": "S64", "c": "<i2", "C": "<u2", "e": "<i4", "E": "<u4", "L": "<i4", "M": "<u1", "q": "<i8", "Q": "<u8",
}  # fmt: skip
SENSORS = ("TimeUS", "GyrX", "GyrY", "GyrZ", "AccX", "AccY", "AccZ")
SETPOINTS = ("TimeUS", "RDes", "PDes", "YDes")
OUTPUTS = ("TimeUS", *[f"C{i + 1}" for i in MOTORS])
SETPOINT_UNITS = np.array([1e-6, *[np.pi / 180.0] * 3])
"""[us] in [s], and [deg/s] in [rad/s]."""
# Pulses of motor outputs [us].
IDLE, FULL = 1000.0, 2000.0


class _Described(NamedTuple):
    """A kind of message: its name, and its bytes behind the head as a record."""

    name: str
    record: np.dtype


def is_dataflash(content: bytes) -> bool:
    """Return true for a file with such a log's format message first."""
    return content[:3] == MAGIC


def read_dataflash(content: bytes, name: str, digest: str) -> FlightLog:
    """Return the log; raises InputError where it lacks a message or is damaged beyond use."""
    kinds, parts = _messages(content, ("IMU", "RCOU", "RATE"))
    imu, outputs = (_table(kinds, parts, message, name) for message in ("IMU", "RCOU"))
    if "I" in (imu.dtype.names or ()):
        imu = imu[imu["I"] == 0]
    sensors, pulses = _columns(imu, SENSORS, name), _columns(outputs, OUTPUTS, name)
    return joined(
        name,
        "ArduPilot DataFlash (.bin)",
        digest,
        sensors[:, 0] * 1e-6,
        sensors[:, 1:4],
        sensors[:, 4:],
        pulses[:, 0] * 1e-6,
        (pulses[:, 1:] - IDLE) / (FULL - IDLE),
        _setpoint(kinds, parts, name),
    )


def logged_tables(content: bytes, messages: tuple[str, ...], name: str) -> dict[str, np.ndarray]:
    """Return the tables of messages that a log describes, by their names; name: that of the file for errors."""
    kinds, parts = _messages(content, messages)
    described = {kind.name for kind in kinds.values()}
    return {message: _table(kinds, parts, message, name) for message in messages if message in described}


def _setpoint(kinds: dict[int, _Described], parts: dict[str, list[bytes]], name: str) -> Array | None:
    """Return times [s] and setpoints of the rates [rad/s] (k, 4); None without them."""
    if not parts["RATE"]:
        return None
    table = _table(kinds, parts, "RATE", name)
    if not set(SETPOINTS) <= set(table.dtype.names or ()):
        return None
    return _columns(table, SETPOINTS, name) * SETPOINT_UNITS


def _messages(content: bytes, wanted: tuple[str, ...]) -> tuple[dict[int, _Described], dict[str, list[bytes]]]:
    """Return the described message kinds, and the bytes of the wanted ones."""
    kinds: dict[int, _Described] = {}
    parts: dict[str, list[bytes]] = {name: [] for name in wanted}
    place, end = 0, len(content)
    while 0 <= place <= end - 3:
        kind = content[place + 2]
        length = FORMAT_LENGTH if kind == FORMAT else kinds[kind].record.itemsize + 3 if kind in kinds else 0
        if content[place : place + 2] != HEAD or not 0 < length <= end - place:
            place = content.find(HEAD, place + 1)
            continue
        if kind == FORMAT:
            kinds |= _described(content[place + 3 : place + length])
        elif kinds[kind].name in parts:
            parts[kinds[kind].name].append(content[place + 3 : place + length])
        place += length
    return kinds, parts


def _described(body: bytes) -> dict[int, _Described]:
    """Return the kind described by a format message, by its type; nothing where the two lengths disagree."""
    number, length, name = body[0], body[1], field_text(body[2:6])
    letters, fields = field_text(body[6:22]), field_text(body[22:]).split(",")
    fits = (
        len(letters) == len(fields) == len(set(fields)) and all(fields) and all(letter in LETTERS for letter in letters)
    )
    if number == FORMAT or not fits:
        return {}
    record = np.dtype([(field, LETTERS[letter]) for field, letter in zip(fields, letters, strict=True)])
    return {number: _Described(name, record)} if record.itemsize + 3 == length else {}


def field_text(field: bytes) -> str:
    """Return the text in a field of fixed length."""
    return field.split(b"\0")[0].decode("ascii", "replace")


def _table(kinds: dict[int, _Described], parts: dict[str, list[bytes]], message: str, name: str) -> np.ndarray:
    record = next((kind.record for kind in kinds.values() if kind.name == message), None)
    if record is None:
        raise InputError(f"has no message {message}; log the inertial sensors and the motor outputs", file=name)
    # A description that a damaged file repeats with another length leaves parts that do not fit.
    return np.frombuffer(b"".join(part for part in parts[message] if len(part) == record.itemsize), record)


def _columns(table: np.ndarray, fields: tuple[str, ...], name: str) -> Array:
    missing = [
        field for field in fields if field not in (table.dtype.names or ()) or table.dtype[field].kind not in "iuf"
    ]
    if missing:
        raise InputError(f"lacks the field {missing[0]}; it is damaged or of another format", file=name)
    return np.column_stack([table[field].astype(float) for field in fields])
