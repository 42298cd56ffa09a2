"""Tables of results folders: numbers as Arrow itself would hand them over."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from plant.errors import StoreError
from tuner.documents.tables import codes_of, numbers

CELLS = [1.5, None, -2.0, float("nan"), None, 6.0, 7.0, None, 9.0]


@pytest.mark.parametrize("part", [slice(0, 27), slice(3, 20), slice(9, 10), slice(0, 0)])
def test_numbers_are_those_of_arrow(part):
    whole = pa.table(
        {
            "broken": pa.chunked_array([pa.array(CELLS * 2), pa.array(CELLS)]),
            "whole": pa.array(range(27)),
            "narrow": pa.array(np.arange(27, dtype=np.float32)),
            "short": pa.array([None, *range(26)], type=pa.int32()),
            "tiny": pa.array([None, *range(26)], type=pa.int8()),
            "truth": pa.array([True, None, False] * 9),
        }
    )
    table = whole.slice(part.start, part.stop - part.start)
    expected = [table.column(name).cast("float64").to_numpy() for name in table.column_names]
    found = numbers(table, table.column_names, Path("some.parquet"))
    np.testing.assert_array_equal(found, np.stack(expected, axis=1))


@pytest.mark.parametrize("kind", [pa.string(), pa.large_string(), pa.dictionary(pa.int8(), pa.string())])
def test_names_are_told_in_order_of_appearance_however_they_are_stored(kind):
    names = ["pitch", "roll", "pitch", "", "yaw", "roll"]
    column = pa.chunked_array([pa.array(part).cast(kind) for part in (["x"], names[:2], names[2:], ["never"])])
    codes, known = codes_of(column.slice(1, len(names)), Path("some.parquet"))
    assert known == ["pitch", "roll", "", "yaw"]
    assert [known[code] for code in codes] == names


@pytest.mark.parametrize("kind", [pa.string(), pa.dictionary(pa.int8(), pa.string())])
def test_a_missing_name_is_refused(kind):
    with pytest.raises(StoreError, match="a name is missing"):
        codes_of(pa.chunked_array([pa.array(["a", None]).cast(kind)]), Path("some.parquet"))
