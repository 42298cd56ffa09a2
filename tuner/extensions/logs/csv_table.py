"""CSV tables whose columns a mapping names."""

from io import StringIO

import numpy as np

from plant.errors import InputError, UnknownNameError
from tuner.extensions.logs.flight_log import Array, FlightLog
from tuner.extensions.logs.mapping import Mapping

MAX_CSV_BYTES = 2**27
"""Largest table that is read [bytes]."""
MAX_COLUMNS, LONGEST_LINE = 500, 2**15


def read_csv(content: bytes, name: str, digest: str, mapping: Mapping, kind: str = "CSV") -> FlightLog:
    """Return the log in a table; raises InputError where it is none or lacks a column."""
    table = read_columns(content, name, mapping.columns, mapping.separator)
    return mapping.log((name, kind, digest), table)


def read_columns(content: bytes, name: str, columns: list[str], separator: str = ",") -> Array:
    """Return named columns (n, columns) of a CSV text: NaN where a cell is no number."""
    import pandas as pd

    text = _text(content, name)
    head = header(text, separator)
    for column in columns:
        if head.count(column) > 1:
            raise InputError(f"has {head.count(column)} columns '{column}'; rename all but one", file=name)
        if column not in head:
            raise UnknownNameError("column", column, [entry[:60] for entry in head[:60]], file=name)
    places = [head.index(column) for column in columns]
    try:
        frame = pd.read_csv(
            StringIO(text),
            sep=separator,
            header=None,
            names=range(len(head)),
            index_col=False,
            skiprows=1,
            usecols=sorted(set(places)),
            on_bad_lines="skip",
            dtype=str,
            engine="c",
            quoting=3,
        )
    except (pd.errors.ParserError, pd.errors.EmptyDataError, ValueError) as error:
        raise InputError(f"is no table of numbers ({str(error).splitlines()[0]})", file=name) from None
    return np.column_stack([np.asarray(pd.to_numeric(frame[place], errors="coerce"), float) for place in places])


def header(text: str, separator: str) -> list[str]:
    """Return the names of the columns of a CSV text."""
    return [entry.strip().strip('"') for entry in text[: text.find("\n")].split(separator)]


def _text(content: bytes, name: str) -> str:
    if len(content) > MAX_CSV_BYTES:
        raise InputError(
            f"has {len(content) / 2**20:,.0f} MiB; of a table at most {MAX_CSV_BYTES / 2**20:,.0f} MiB are read",
            file=name,
        )
    if b"\0" in content:
        raise InputError("holds zero bytes, so it is no text; give a CSV table", file=name)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"is not UTF-8 text ({error.reason} at byte {error.start}); save it as UTF-8", file=name
        ) from None
    first = text.find("\n")
    if not 0 < first <= LONGEST_LINE or text.count(",", 0, first) > MAX_COLUMNS:
        raise InputError("has no line of column names at its head", file=name)
    return text
