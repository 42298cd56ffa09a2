"""Tables of results folders of earlier versions: Parquet files, which pyarrow reads where it is installed."""

from io import BytesIO

import numpy as np

from plant.errors import require_package
from tuner.store.columns import Coded, in_codes


class ParquetTable:
    """A table in the bytes of a Parquet file; its methods are those of `NpzTable`."""

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
