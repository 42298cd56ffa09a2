"""Tables of columns as tables of Arrow and as Parquet files.

Most constructors of pyarrow, even those that are given arrays, import pandas to ask whether they are given something of it, which
takes 0.3 s of processor time. So columns are made from their buffers here.
"""

import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from tuner.store.columns import filled


def parquet_bytes(columns: Mapping[str, Any]) -> bytes:
    """Return a table as the bytes of a Parquet file; a number that is missing is null."""
    sink = io.BytesIO()
    pq.write_table(arrow_table(columns), sink)
    return sink.getvalue()


def arrow_table(columns: Mapping[str, Any], with_nulls: bool = True) -> pa.Table:
    """Return a table of Arrow; with_nulls: whether NaN stands as null."""
    table = filled(columns)
    return pa.Table.from_arrays([arrow_column(values, with_nulls) for values in table.values()], names=list(table))


def arrow_column(values: Any, with_nulls: bool = True) -> pa.Array:
    """Return texts, booleans, numbers or rows of numbers (rows, n) as an Arrow column."""
    if isinstance(values, pa.Array):
        return values
    array = np.asarray(values)
    if array.dtype == bool:
        return pa.Array.from_buffers(pa.bool_(), len(array), [None, _bits(array)])
    if array.dtype.kind == "U" or (array.dtype == object and any(isinstance(value, str) for value in array)):
        return _texts(array.tolist(), pa.large_string(), np.int64)
    number = array.astype(np.float64) if array.dtype == object else array
    return _lists(number, with_nulls) if number.ndim == 2 else _numbers(number, with_nulls)


def in_codes(texts: Sequence[str] | np.ndarray) -> pa.Array:
    """Return texts as codes of the distinct texts, in alphabetical order."""
    listed = texts.tolist() if isinstance(texts, np.ndarray) else texts
    names = sorted(set(listed))
    code = {text: i for i, text in enumerate(names)}
    return coded(np.fromiter(map(code.__getitem__, listed), np.min_scalar_type(-len(names)), len(listed)), names)


def coded(codes: np.ndarray, categories: Sequence[str]) -> pa.Array:
    """Return texts by their codes (rows,), integers with a sign, among categories."""
    return pa.DictionaryArray.from_arrays(_numbers(codes), _texts(categories, pa.string(), np.int32))


def _texts(texts: Sequence[str], kind: Any, offset: type) -> pa.Array:
    written = [text.encode() for text in texts]
    ends = np.cumsum([0, *map(len, written)], dtype=offset)
    return pa.Array.from_buffers(kind, len(texts), [None, pa.py_buffer(ends), pa.py_buffer(b"".join(written))])


def _numbers(values: np.ndarray, with_nulls: bool = False) -> pa.Array:
    missing = np.isnan(values) if with_nulls and values.dtype.kind == "f" else np.zeros(0, dtype=bool)
    validity = _bits(~missing) if missing.any() else None
    content = pa.py_buffer(np.ascontiguousarray(values))
    return pa.Array.from_buffers(pa.from_numpy_dtype(values.dtype), len(values), [validity, content])


def _lists(values: np.ndarray, with_nulls: bool) -> pa.Array:
    ends = np.arange(len(values) + 1, dtype=np.int32) * values.shape[1]
    return pa.ListArray.from_arrays(_numbers(ends), _numbers(values.ravel(), with_nulls))


def _bits(truths: np.ndarray) -> pa.Buffer:
    return pa.py_buffer(np.packbits(truths, bitorder="little"))
