"""Tables of results folders: numbers as Arrow itself would hand them over."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from tuner.documents.tables import numbers

CELLS = [1.5, None, -2.0, float("nan"), None, 6.0, 7.0, None, 9.0]


@pytest.mark.parametrize("part", [slice(0, 27), slice(3, 20), slice(9, 10), slice(0, 0)])
def test_numbers_are_those_of_arrow(part):
    whole = pa.table({
        "broken": pa.chunked_array([pa.array(CELLS * 2), pa.array(CELLS)]),
        "whole": pa.array(range(27)),
        "narrow": pa.array(np.arange(27, dtype=np.float32)),
    })  # fmt: skip
    table = whole.slice(part.start, part.stop - part.start)
    expected = [table.column(name).cast("float64").to_numpy() for name in table.column_names]
    found = numbers(table, table.column_names, Path("some.parquet"))
    np.testing.assert_array_equal(found, np.stack(expected, axis=1))
