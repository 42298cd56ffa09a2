"""Tables of a results folder, validated on reading: whatever is missing or wrong becomes a StoreError naming the file."""

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO, StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plant.input_files import MAX_TABLE_BYTES, read_input
from tuner.store.columns import Coded
from tuner.store.document import read_text, refuse
from tuner.store.tables import TableFile
from tuner.text.units import in_degrees

if TYPE_CHECKING:
    import pandas as pd

Group = tuple[list[str], np.ndarray]
"""The names that the rows of a group share, and their numbers (rows, columns)."""
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
    """Use of rotors or inputs by a point in a scenario: density (bands,) [1/sqrt(Hz)] at frequency (bands,) [Hz]."""

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
    """Return a table as it stands, whatever its kind of file; StoreError where it is missing or damaged."""
    import pandas as pd

    if file.suffix != ".csv":
        return frame_of(TableFile(file))
    try:
        return pd.read_csv(BytesIO(read_input(file, MAX_TABLE_BYTES)))
    except FileNotFoundError:
        raise refuse(file, "there is no such file") from None
    except (OSError, ValueError) as error:
        raise refuse(file, f"not a readable table ({str(error).splitlines()[0]:.80})") from None


def frame_of(table: TableFile) -> "pd.DataFrame":
    """Return all columns of a table; rows of numbers are arrays."""
    import pandas as pd

    def column(values: np.ndarray | Coded) -> Any:
        if isinstance(values, Coded):
            return pd.Categorical.from_codes(values.codes, values.names) if values.categorical else values.texts()
        return list(values) if values.ndim == 2 else values

    return pd.DataFrame({name: column(table.column(name)) for name in table.names})


def groups(
    file: Path, names: Sequence[str], columns: Sequence[str], optional: Sequence[str] = (), by_name: bool = False
) -> Iterator[Group]:
    """Yield the rows of a table with the same names, in order of first appearance; nothing where there is no file.

    Rows of a group need not be neighbours. optional: further columns, all or none. by_name: groups in the order of the
    first name, then of the second, and so on.
    """
    if not file.exists():
        return
    table = TableFile(file)
    more = optional if set(optional) <= set(table.names) else ()
    codes = [in_order(table.coded(name)) for name in names]
    values = table.block([*columns, *more])
    if not len(values):
        return
    group = np.ravel_multi_index([code for code, _ in codes], [len(categories) for _, categories in codes])
    order = np.argsort(group, kind="stable")
    starts = np.flatnonzero(np.diff(group[order], prepend=-1))
    rows = np.split(order, starts[1:])
    for part in rows if by_name else sorted(rows, key=lambda part: part[0]):
        yield [categories[int(code[part[0]])] for code, categories in codes], values[part]


def in_order(column: Coded) -> tuple[np.ndarray, list[str]]:
    """Return a column of texts as codes (rows,) into those that appear, in order of appearance."""
    used, first, place = np.unique(column.codes, return_index=True, return_inverse=True)
    order = np.argsort(first)
    return np.argsort(order)[place], [column.names[code] for code in used[order]]


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
