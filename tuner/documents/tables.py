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
# Types of Arrow whose buffers hold plain numbers.
PLAIN = {"double": np.float64, "float": np.float32, "int64": np.int64, "int32": np.int32}
SAME_VALUES = {"string": {"string", "large_string"}, "float64": {"double"}}
"""Type of Arrow -> names of the types whose `to_pylist` is the same."""
CODED = {f"dictionary<values=string, indices=int{bits}, ordered=0>" for bits in (8, 16, 32)}
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
        source = pq.ParquetFile(BytesIO(read_input(file, MOST_TABLE)))
        missing = [name for name in columns if name not in source.schema_arrow.names]
        if missing:
            raise refuse(file, f"the column '{missing[0]}' is missing")
        more = optional if set(optional) <= set(source.schema_arrow.names) else ()
        return source.read([*columns, *more])
    except FileNotFoundError:
        raise refuse(file, "there is no such file") from None
    except (OSError, pa.ArrowException) as error:
        raise refuse(file, f"not a readable Parquet file ({str(error).splitlines()[0]:.80})") from None


def numbers(table: "pa.Table", names: list[str], file: Path) -> np.ndarray:
    """Return columns of a table as float64 (rows, columns); nulls are NaN."""
    try:
        cast = [floats_of(table.column(name)) for name in names]
    except OTHER_TYPE as error:
        raise refuse(file, f"a column holds no numbers ({error})") from None
    return np.stack(cast, axis=1) if cast else np.empty((table.num_rows, 0))


def floats_of(column: Any) -> np.ndarray:
    """Return an Arrow column as float64, nulls as NaN.

    Its own `to_numpy` imports pandas, which takes 0.3 s, and its `cast`, which other types than those of runs need, functions of
    pyarrow that take 0.03 s.
    """
    kind = str(column.type)
    array = (column if kind in PLAIN or kind == "bool" else column.cast("float64")).combine_chunks()
    part, (validity, data) = slice(array.offset, array.offset + len(array)), array.buffers()
    if not len(array):
        return np.empty(0)
    stored = bits_of(data) if kind == "bool" else np.frombuffer(data, PLAIN.get(kind, np.float64))
    values = stored[part].astype(np.float64, copy=False)
    return np.where(bits_of(validity)[part], values, np.nan) if array.null_count else values


def bits_of(buffer: Any) -> np.ndarray:
    """Return the bits of a buffer, 0 or 1 each."""
    return np.unpackbits(np.frombuffer(buffer, dtype=np.uint8), bitorder="little")


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
    group = np.ravel_multi_index([code for code, _ in codes], [len(categories) for _, categories in codes])
    order = np.argsort(group, kind="stable")
    starts = np.flatnonzero(np.diff(group[order], prepend=-1))
    values = numbers(table, [name for name in table.column_names if name not in names], file)
    rows = np.split(order, starts[1:])
    for part in rows if by_name else sorted(rows, key=lambda part: part[0]):
        yield [categories[int(code[part[0]])] for code, categories in codes], values[part]


def values_of(column: Any, kind: str) -> list[Any]:
    """Return an Arrow column as a list of values of a type of `SAME_VALUES`, nulls as None; no `cast` where none is needed."""
    return (column if str(column.type) in SAME_VALUES[kind] else column.cast(kind)).to_pylist()


def codes_of(column: Any, file: Path) -> tuple[np.ndarray, list[str]]:
    """Return a text column as codes (rows,) into a list of names, which are in order of appearance."""
    try:
        array = column.combine_chunks()
        # Those of runs are coded already; Arrow's own functions, which code others, take 0.03 s to import.
        encoded = array if str(array.type) in CODED else array.cast("string").dictionary_encode()
    except OTHER_TYPE as error:
        raise refuse(file, f"a column holds no text ({error})") from None
    if encoded.null_count:
        raise refuse(file, "a name is missing")
    return in_order(np.from_dlpack(encoded.indices), encoded.dictionary.to_pylist())


def in_order(codes: np.ndarray, names: list[str]) -> tuple[np.ndarray, list[str]]:
    """Return codes (rows,) into known names as codes into those that appear, in order of appearance."""
    used, first, place = np.unique(codes, return_index=True, return_inverse=True)
    order = np.argsort(first)
    return np.argsort(order)[place], [names[code] for code in used[order]]


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
    rows = groups(file, ("point", "scenario"), ("frequency", "density"))
    return [PointSpectrum(point, scenario, *values.T) for (point, scenario), values in rows]
