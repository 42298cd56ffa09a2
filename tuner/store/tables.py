"""Files of tables in results folders: .npz and, in folders of earlier versions, Parquet."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from zipfile import BadZipFile
from zlib import error as DeflateError

import numpy as np

from plant.errors import require_package
from plant.input_files import MAX_TABLE_BYTES, read_input
from tuner.store.columns import Coded, in_codes
from tuner.store.document import refuse
from tuner.store.npz import NpzTable

KIND, FORMER = ".npz", ".parquet"
# What the readers of both raise where a file is damaged.
UNREADABLE = (
    ValueError,
    TypeError,
    LookupError,
    ArithmeticError,
    OSError,
    EOFError,
    RuntimeError,
    BadZipFile,
    DeflateError,
)


class TableFile:
    """Table in a file, read column by column.

    StoreError where it is missing or damaged.
    content: of the file, where it is read already. names: of the columns.
    """

    def __init__(self, file: Path, content: bytes | None = None) -> None:
        self._file = file
        with self._refusing():
            content = read_input(file, MAX_TABLE_BYTES) if content is None else content
            self._table = ParquetTable(content) if file.suffix == FORMER else NpzTable(content)
            self.names = self._table.names

    def column(self, name: str) -> np.ndarray | Coded:
        """Return a column: numbers (rows,), rows of numbers (rows, n) or coded texts."""
        if name not in self.names:
            raise refuse(self._file, f"the column '{name}' is missing")
        with self._refusing():
            return self._table.column(name)

    def numbers(self, name: str, rows: bool = False) -> np.ndarray:
        """Return a column of numbers as float64 (rows,); rows: one of rows of numbers (rows, n)."""
        values = self.column(name)
        if isinstance(values, Coded) or values.ndim != 1 + rows:
            raise refuse(self._file, f"the column '{name}' holds no {'rows of ' * rows}numbers")
        return values.astype(np.float64, copy=False)

    def block(self, names: Sequence[str], optional: bool = False) -> np.ndarray:
        """Return columns of numbers (rows, columns); optional: any but the first is NaN where it is missing."""
        first = self.numbers(names[0])
        missing = np.full(len(first), np.nan)
        others = [missing if optional and name not in self.names else self.numbers(name) for name in names[1:]]
        return np.stack([first, *others], axis=1)

    def coded(self, name: str) -> Coded:
        """Return a column of texts."""
        values = self.column(name)
        if not isinstance(values, Coded):
            raise refuse(self._file, f"the column '{name}' holds no text")
        return values

    def note(self, name: str) -> str:
        """Return a text next to the columns."""
        with self._refusing():
            return self._table.note(name)

    @contextmanager
    def _refusing(self) -> Iterator[None]:
        try:
            yield
        except FileNotFoundError:
            raise refuse(self._file, "there is no such file") from None
        except UNREADABLE as error:
            reason = (str(error).splitlines() or [type(error).__name__])[0]
            raise refuse(self._file, f"not a readable table ({reason:.80})") from error


class ParquetTable:
    """Table in the bytes of a Parquet file, which pyarrow reads; its methods are those of `NpzTable`."""

    def __init__(self, content: bytes) -> None:
        require_package("pyarrow", "parquet", key="a results folder of an earlier version")
        from pyarrow.parquet import ParquetFile

        self._file = ParquetFile(BytesIO(content))
        self.names: list[str] = self._file.schema_arrow.names

    def column(self, name: str) -> np.ndarray | Coded:
        """Return a column: numbers (rows,), rows of numbers (rows, n) or coded texts; missing numbers are NaN."""
        import pandas as pd

        values = self._file.read([name]).column(name).to_pandas()
        if isinstance(values.dtype, pd.CategoricalDtype):
            if values.isna().any():
                raise ValueError("a text is missing")
            return Coded(values.cat.codes.to_numpy(), [str(text) for text in values.cat.categories])
        array = values.to_numpy()
        if array.dtype.kind in "biuf":
            return array
        kinds = {type(value) for value in array}
        if str in kinds:
            return in_codes([text if isinstance(text, str) else "" for text in array], categorical=False)
        return (np.stack(array) if kinds == {np.ndarray} else array).astype(np.float64)

    def note(self, name: str) -> str:
        """Return a text of the file's metadata."""
        return self._file.schema_arrow.metadata[name.partition(".")[0].encode()].decode()


def table_files(folder: Path) -> list[Path]:
    """Return the files of tables in a folder by name.

    One of an earlier version counts only where there is no later one of its name.
    """
    files = {file.stem: file for kind in (FORMER, KIND) for file in folder.glob(f"*{kind}")}
    return [files[name] for name in sorted(files)]


def table_file(folder: Path, name: str) -> Path:
    """Return the file of a table, written or not; name: without its ending."""
    former = folder / f"{name}{FORMER}"
    written = folder / f"{name}{KIND}"
    return former if former.exists() and not written.exists() else written
