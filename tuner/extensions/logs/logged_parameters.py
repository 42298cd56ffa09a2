"""Parameters in a flight log: those that the vehicle had when the log began."""

import re
from contextlib import redirect_stdout
from io import StringIO
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from plant.errors import InputError, one_line, require_package, shortened
from tuner.extensions.logs.dataflash import field_text, logged_tables
from tuner.extensions.logs.ulog import ReadOnce

NAME = re.compile(r"[A-Z][A-Z0-9_]{0,15}")
MAX_PARAMETERS = 20_000
"""Largest number of parameters, ten times that of any vehicle."""


class LoggedParameters(NamedTuple):
    """Parameters of a log.

    Attributes:
        firmware: Firmware as the log names it, "" if it does not.
        version: Version of the firmware, such as 1.14.3, "" if the log does not state it.
        values: Name -> value when the log began.
        changed: Name -> (value, later value) of those that changed during the log, as far as it is read.
    """

    firmware: str
    version: str
    values: dict[str, float]
    changed: dict[str, tuple[float, float]]


def ulog_parameters(content: bytes, name: str) -> LoggedParameters:
    """Return the initial parameters of a ULog; InputError where it is damaged, MissingPackageError without pyulog."""
    require_package("pyulog", "logs", key=name)
    from pyulog import ULog

    try:
        # It prints what it finds damaged.
        with redirect_stdout(StringIO()):
            log = ULog(ReadOnce(content), [], parse_header_only=True)
        initial, info = dict(log.initial_parameters), dict(log.msg_info_dict)
    # The reader meets whatever a damaged file holds, and raises as many kinds of errors.
    except Exception as error:
        raise InputError(f"is no ULog that can be read ({type(error).__name__})", file=name) from None
    values = _checked({str(key): float(value) for key, value in initial.items()}, name)
    return LoggedParameters(shortened(one_line(str(info.get("sys_name", "")))), _ulog_version(info), values, {})


def dataflash_parameters(content: bytes, name: str) -> LoggedParameters:
    """Return the first value of each parameter of a DataFlash log; InputError where it is damaged."""
    tables = logged_tables(content, ("PARM", "MSG"), name)
    first: dict[str, float] = {}
    last: dict[str, float] = {}
    for field, value in _parameter_rows(tables.get("PARM"), name):
        first.setdefault(field, value)
        last[field] = value
    values = _checked(first, name)
    changed = {field: (value, last[field]) for field, value in values.items() if last[field] != value}
    return LoggedParameters(*_banner(tables.get("MSG")), values, changed)


def _parameter_rows(table: np.ndarray | None, name: str) -> list[tuple[str, float]]:
    fields = () if table is None else table.dtype.names or ()
    if table is None or not {"Name", "Value"} <= set(fields) or table.dtype["Value"].kind not in "iuf":
        return []
    # A row for each parameter at each start; a damaged log could hold any number.
    if len(table) > 10 * MAX_PARAMETERS:
        raise InputError(f"has {len(table):,} messages PARM; at most {10 * MAX_PARAMETERS:,} are read", file=name)
    texts = [field_text(bytes(text)) for text in table["Name"].tolist()]
    return list(zip(texts, table["Value"].astype(float).tolist(), strict=True))


def _banner(table: np.ndarray | None) -> tuple[str, str]:
    """Return vehicle and version of the first message with both."""
    for raw in [] if table is None or "Message" not in (table.dtype.names or ()) else table["Message"][:1000].tolist():
        match = re.match(r"([A-Za-z:]{4,20})[ -]V?(\d+\.\d+(?:\.\d+)?)", field_text(bytes(raw)))
        if match:
            return match[1], match[2]
    return "", ""


def _ulog_version(info: dict[Any, Any]) -> str:
    """Return the version of the firmware: bytes major, minor, patch."""
    packed = info.get("ver_sw_release", 0)
    if not isinstance(packed, int) or packed <= 0:
        return ""
    return ".".join(str(packed >> shift & 0xFF) for shift in (24, 16, 8))


def _checked(values: dict[str, float], name: str) -> dict[str, float]:
    """Return the finite parameters; InputError where a name is none, or none is there."""
    unnamed = next((key for key in values if not NAME.fullmatch(key)), None)
    if unnamed is not None:
        raise InputError(f"holds the parameter '{shortened(one_line(unnamed))}'; it is damaged", file=name)
    finite = {key: value for key, value in values.items() if isfinite(value)}
    if not 0 < len(finite) <= MAX_PARAMETERS:
        message = f"holds {len(finite):,} parameters; give a log that begins where logging began"
        raise InputError(message, file=name)
    return finite
