"""Tables of a results folder, read with suspicion: whatever is missing or wrong becomes a StoreError naming the file."""

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO, StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plant.input_files import MOST_TABLE, read_input
from tuner.store.document import read_text, refuse
from tuner.text.units import in_degrees

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa

Group = tuple[list[str], np.ndarray]
"""The names that the rows of a group share, and their numbers (rows, columns)."""
# What pyarrow raises where a column holds something else.
OTHER_TYPE = (ValueError, TypeError, NotImplementedError)
FAN_KEYS = ("point", "scenario", "signal", "unit")
FAN_NUMBERS = ("time", "reference", "low", "median", "high")


@dataclass(frozen=True)
class Fan:
    """One signal of a point in a scenario: time [s], reference, 5 %, 50 % and 95 % over flights, each (instants,).

    worst: the same signal in the flight in which the point did worst, number `flight` of the held-out ones; None where unknown.
    Angles are in degrees.
    """

    point: str
    scenario: str
    signal: str
    unit: str
    time: np.ndarray
    reference: np.ndarray
    low: np.ndarray
    median: np.ndarray
    high: np.ndarray
    worst: np.ndarray | None = None
    flight: int | None = None


@dataclass(frozen=True)
class PointSpectrum:
    """What a point asks of rotors or inputs in a scenario: density (bands,) [1/sqrt(Hz)] at frequency (bands,) [Hz]."""

    point: str
    scenario: str
    frequency: np.ndarray
    density: np.ndarray


@dataclass(frozen=True)
class Columns:
    """The columns of a CSV file as text."""

    file: Path
    columns: dict[str, list[str]]

    @classmethod
    def read(cls, file: Path) -> "Columns":
        """Return the columns of a CSV file with a header and at least one row."""
        rows = [row for row in csv.reader(StringIO(read_text(file))) if row]
        if len(rows) < 2:
            raise refuse(file, "the table has no rows")
        for i, row in enumerate(rows[1:], start=1):
            if len(row) != len(rows[0]):
                raise refuse(file, f"row {i} has {len(row)} cells and the header {len(rows[0])}")
        return cls(file, {name: list(cells) for name, *cells in zip(*rows, strict=True)})

    def text(self, name: str) -> list[str]:
        """Return a column as it stands."""
        if name not in self.columns:
            raise refuse(self.file, f"the column '{name}' is missing")
        return self.columns[name]

    def numbers(self, name: str) -> np.ndarray:
        """Return a column of numbers (rows,); empty cells are NaN."""
        try:
            return np.array([float(cell) if cell else np.nan for cell in self.text(name)])
        except ValueError as error:
            raise refuse(self.file, f"the column '{name}' holds no number ({error})") from None

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(next(iter(self.columns.values())))

    def block(self, names: Sequence[str], optional: bool = False) -> np.ndarray:
        """Return columns of numbers (rows, columns); optional: one that is not there is NaN."""
        missing = np.full(self.rows, np.nan)
        parts = [missing if optional and name not in self.columns else self.numbers(name) for name in names]
        return np.stack(parts, axis=1) if parts else np.empty((self.rows, 0))

    def flags(self, name: str) -> np.ndarray:
        """Return a column of true and false (rows,)."""
        cells = [cell.lower() for cell in self.text(name)]
        if not set(cells) <= {"true", "false"}:
            raise refuse(self.file, f"the column '{name}' holds something else than True and False")
        return np.array([cell == "true" for cell in cells])


def read_frame(file: Path) -> "pd.DataFrame":
    """Return a CSV or Parquet table as it stands; StoreError where it is missing or damaged."""
    import pandas as pd

    try:
        if file.suffix == ".csv":
            return pd.read_csv(BytesIO(read_input(file, MOST_TABLE)))
        return pd.read_parquet(BytesIO(read_input(file, MOST_TABLE)))
    except FileNotFoundError:
        raise refuse(file, "there is no such file") from None
    except (OSError, ValueError) as error:
        raise refuse(file, f"not a readable table ({str(error).splitlines()[0]:.80})") from None


def read_table(file: Path, columns: Sequence[str], optional: Sequence[str] = ()) -> "pa.Table":
    """Return these columns of a Parquet file, and of the optional ones all or none."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        found = pq.ParquetFile(BytesIO(read_input(file, MOST_TABLE)))
        missing = [name for name in columns if name not in found.schema_arrow.names]
        if missing:
            raise refuse(file, f"the column '{missing[0]}' is missing")
        more = optional if set(optional) <= set(found.schema_arrow.names) else ()
        return found.read([*columns, *more])
    except FileNotFoundError:
        raise refuse(file, "there is no such file") from None
    except (OSError, pa.ArrowException) as error:
        raise refuse(file, f"not a readable Parquet file ({str(error).splitlines()[0]:.80})") from None


def numbers(table: "pa.Table", names: list[str], file: Path) -> np.ndarray:
    """Return columns of a table as float64 (rows, columns); nulls are NaN."""
    try:
        cast = [floats_of(table.column(name).cast("float64").combine_chunks()) for name in names]
    except OTHER_TYPE as error:
        raise refuse(file, f"a column holds no numbers ({error})") from None
    return np.stack(cast, axis=1) if cast else np.empty((table.num_rows, 0))


def floats_of(column: Any) -> np.ndarray:
    """Return an Arrow array of float64, nulls as NaN; its own `to_numpy` imports pandas, which takes 0.4 s."""
    part, (known, data) = slice(column.offset, column.offset + len(column)), column.buffers()
    if not len(column):
        return np.empty(0)
    values = np.frombuffer(data)[part]
    if not column.null_count:
        return values
    return np.where(np.unpackbits(np.frombuffer(known, dtype=np.uint8), bitorder="little")[part], values, np.nan)


def groups(
    file: Path, names: Sequence[str], columns: Sequence[str], optional: Sequence[str] = (), by_name: bool = False
) -> Iterator[Group]:
    """Yield the rows of a Parquet file with the same names, in order of first appearance; nothing where there is no file.

    Rows of a group need not be neighbours. optional: further columns, all or none. by_name: groups in the order of the
    first name, then of the second, and so on.
    """
    if not file.exists():
        return
    table = read_table(file, (*names, *columns), optional)
    if table.num_rows == 0:
        return
    codes = [codes_of(table.column(name), file) for name in names]
    group = np.ravel_multi_index([code for code, _ in codes], [len(known) for _, known in codes])
    order = np.argsort(group, kind="stable")
    starts = np.flatnonzero(np.diff(group[order], prepend=-1))
    values = numbers(table, [name for name in table.column_names if name not in names], file)
    rows = np.split(order, starts[1:])
    for part in rows if by_name else sorted(rows, key=lambda part: part[0]):
        yield [known[int(code[part[0]])] for code, known in codes], values[part]


def codes_of(column: Any, file: Path) -> tuple[np.ndarray, list[str]]:
    """Return a text column as codes (rows,) into a list of names, which are in order of appearance."""
    try:
        encoded = column.cast("string").combine_chunks().dictionary_encode()
    except OTHER_TYPE as error:
        raise refuse(file, f"a column holds no text ({error})") from None
    if encoded.null_count:
        raise refuse(file, "a name is missing")
    return np.from_dlpack(encoded.indices), encoded.dictionary.to_pylist()


def read_fans(file: Path, worst: Sequence[str] = (), by_name: bool = False) -> list[Fan]:
    """Return the fans of every point, scenario and signal, none where there is no file; order and `worst` as of `groups`."""
    fans = []
    for (point, scenario, signal, unit), values in groups(file, FAN_KEYS, FAN_NUMBERS, worst, by_name):
        shown, factor = in_degrees(unit)
        time, *series = values.T
        flight = int(series.pop()[0]) if values.shape[1] > len(FAN_NUMBERS) else None
        fans.append(Fan(point, scenario, signal, shown, time, *[entry * factor for entry in series], flight=flight))
    return fans


def read_spectra(file: Path) -> list[PointSpectrum]:
    """Return the spectra of points, none where there is no file."""
    found = groups(file, ("point", "scenario"), ("frequency", "density"))
    return [PointSpectrum(point, scenario, *values.T) for (point, scenario), values in found]
