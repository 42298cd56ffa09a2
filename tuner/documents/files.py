"""Files of a results folder, read with suspicion: whatever is missing or wrong becomes a StoreError naming the file."""

import csv
import json
from dataclasses import dataclass
from io import BytesIO, StringIO
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from plant.errors import StoreError
from plant.input_files import MOST_TABLE, read_input, read_input_text
from tuner.store.advice import kind_of, mend


def refuse(file: Path, what: str) -> StoreError:
    """Return the error for a file that cannot be used; what: what is wrong with it."""
    folder = next((above for above in list(file.parents)[:2] if kind_of(above) is not None), file.parent)
    return StoreError(f"{file}: {what}; {mend(folder, file.relative_to(folder).as_posix())}")


def read_text(file: Path) -> str:
    """Return the content of a text file."""
    try:
        return read_input_text(file)
    except FileNotFoundError:
        raise refuse(file, "there is no such file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise refuse(file, f"the file cannot be read ({error})") from None


@dataclass(frozen=True)
class Node:
    """A value inside a JSON file that knows where it stands. key: dotted, "" for the whole document."""

    value: Any
    file: Path
    key: str = ""

    @classmethod
    def read(cls, file: Path) -> "Node":
        """Return the object that a JSON file holds."""
        try:
            value = json.loads(read_text(file))
        except json.JSONDecodeError as error:
            raise refuse(file, f"not JSON, {error.msg} in line {error.lineno}") from None
        return cls(cls(value, file)._expect(dict, "an object"), file)

    def __getitem__(self, name: str) -> "Node":
        entries = self._expect(dict, "an object")
        if name not in entries:
            raise refuse(self.file, f"the key '{self._below(name)}' is missing")
        return Node(entries[name], self.file, self._below(name))

    def get(self, name: str, otherwise: Any = None) -> Any:
        """Return the bare value of a key that may be missing."""
        return self._expect(dict, "an object").get(name, otherwise)

    def entries(self) -> list["Node"]:
        """Return the elements of a list."""
        values = self._expect(list, "a list")
        return [Node(value, self.file, f"{self.key}[{i}]") for i, value in enumerate(values)]

    def items(self) -> list[tuple[str, "Node"]]:
        """Return the keys of an object with their values."""
        return [(name, self[name]) for name in self._expect(dict, "an object")]

    def text(self) -> str:
        """Return a text."""
        return self._expect(str, "a text")

    def number(self) -> float:
        """Return a finite number."""
        value = self._expect((int, float), "a number")
        if isinstance(value, bool) or not isfinite(value):
            raise refuse(self.file, f"'{self.key}' is {value!r} and not a finite number")
        return float(value)

    def _expect(self, kind: type | tuple[type, ...], name: str) -> Any:
        if not isinstance(self.value, kind):
            raise refuse(self.file, f"'{self.key or 'the file'}' is {self.value!r:.60} and not {name}")
        return self.value

    def _below(self, name: str) -> str:
        return f"{self.key}.{name}" if self.key else name


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

    def flags(self, name: str) -> np.ndarray:
        """Return a column of true and false (rows,)."""
        cells = [cell.lower() for cell in self.text(name)]
        if not set(cells) <= {"true", "false"}:
            raise refuse(self.file, f"the column '{name}' holds something else than True and False")
        return np.array([cell == "true" for cell in cells])


def read_table(file: Path, columns: list[str], optional: list[str] | None = None) -> pa.Table:
    """Return these columns of a Parquet file, and of the optional ones all or none."""
    try:
        found = pq.ParquetFile(BytesIO(read_input(file, MOST_TABLE)))
        missing = [name for name in columns if name not in found.schema_arrow.names]
        if missing:
            raise refuse(file, f"the column '{missing[0]}' is missing")
        more = optional if optional and set(optional) <= set(found.schema_arrow.names) else []
        return found.read(columns + more)
    except FileNotFoundError:
        raise refuse(file, "there is no such file") from None
    except (OSError, pa.ArrowException) as error:
        raise refuse(file, f"not a readable Parquet file ({str(error).splitlines()[0]:.80})") from None


def numbers(table: pa.Table, names: list[str], file: Path) -> np.ndarray:
    """Return columns of a table as float64 (rows, columns); nulls are NaN."""
    try:
        cast = [table.column(name).cast(pa.float64()).to_numpy() for name in names]
    except pa.ArrowException as error:
        raise refuse(file, f"a column holds no numbers ({error})") from None
    return np.stack(cast, axis=1) if cast else np.empty((table.num_rows, 0))
