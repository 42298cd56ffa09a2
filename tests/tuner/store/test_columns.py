"""Tables that are written without pandas: pandas reads from them what it would have written itself."""

import io
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.tables import frame_written
from tuner.store.columns import columns_of, csv_text, filled, in_codes, stacked
from tuner.store.npz import npz_bytes

ROOT = Path(__file__).parents[3]
NUMBERS = [0.1, -0.0, 1e-308, np.inf, np.nan, 3.0, 1 / 3]
TABLES = {
    "every kind": {
        "text": ["a", "", 'a "b", c', "µ\n", "nan", "é", "x"],
        "repeated": "all the same",
        "number": NUMBERS,
        "array": np.array(NUMBERS),
        "short": np.array(NUMBERS, dtype=np.float32),
        "count": list(range(7)),
        "small": np.int32(5),
        "true": np.arange(7) % 2 == 0,
        "both": [True, False] * 3 + [True],
        "references": np.repeat(np.array(["p", "q"], dtype=object), (3, 4)),
        "fixed": np.array(list("abcdefg")),
        "sparse": [None, 1.5, None, 2, None, np.float64(0.1), None],
    },
    "rows": columns_of([{"a": 1.5, "b": "x"}, {"b": "y", "c": 2}, {"a": None, "b": "z", "c": 1}]),
    "nine rows": {"true": np.arange(9) != 4, "number": np.where(np.arange(9) == 8, np.nan, 0.1)},
    "every other one": {"number": np.arange(20.0)[::2], "column": np.arange(20.0).reshape(10, 2)[:, 1]},
    "texts alone": {"a": ["x", "y"]},
    "no rows": {"a": np.empty(0), "b": np.empty(0, dtype=np.int32)},
}


def by_way_of_parquet(table):
    """A table as pandas reads what it wrote as Parquet, as earlier versions did."""
    written = io.BytesIO()
    pd.DataFrame(table).to_parquet(written, index=False)
    return pd.read_parquet(written)


@pytest.mark.parametrize("name", TABLES)
def test_csv_is_what_pandas_writes(name):
    expected = pd.DataFrame(TABLES[name]).to_csv(index=False, float_format="%.17g", lineterminator="\n")
    assert csv_text(TABLES[name]) == expected


@pytest.mark.parametrize("name", TABLES)
def test_tables_are_read_as_those_of_pandas_in_parquet(name):
    pd.testing.assert_frame_equal(frame_written(TABLES[name]), by_way_of_parquet(TABLES[name]))


@pytest.mark.parametrize("name", TABLES)
def test_numpy_reads_the_arrays(name):
    found = np.load(io.BytesIO(npz_bytes(TABLES[name])), allow_pickle=False)
    for column, values in pd.DataFrame(TABLES[name]).items():
        texts = f"{column}.texts"
        read = found[texts][found[column]] if texts in found else found[column]
        np.testing.assert_array_equal(read, values.to_numpy())


def test_rows_of_numbers_are_what_pandas_writes():
    curves = [np.array(row, dtype=np.float32) for row in ([0.1, np.nan, 2.0], [3.0, np.inf, 5.0])]
    for stored in (curves, np.stack(curves), np.asfortranarray(np.stack(curves))):
        found = frame_written({"curve": stored})["curve"].tolist()
        there = by_way_of_parquet({"curve": curves})["curve"].tolist()
        assert [row.dtype for row in found] == [row.dtype for row in there]
        np.testing.assert_array_equal(np.stack(found), np.stack(there))


def test_coded_texts_are_the_categories_of_pandas():
    texts = ["x", "roll", "x", "é", "", "roll"]
    expected = by_way_of_parquet({"name": pd.Categorical(texts)})
    pd.testing.assert_frame_equal(frame_written({"name": in_codes(texts)}), expected)


@pytest.mark.parametrize("count", [0, 127, 128, 129, 200, 40_000])
def test_coded_texts_are_read_again_however_many_there_are(count):
    texts = [f"p{i:05d}" for i in range(count)]
    assert frame_written({"name": in_codes(texts)})["name"].tolist() == texts


def test_tables_are_stacked_as_by_pandas():
    parts = [
        {"name": "a", "value": np.arange(3.0), "flight": np.int32(1), "signal": ["x", "y", "z"]},
        {"name": "b", "value": np.array([np.nan]), "flight": np.int32(2), "signal": ["x"]},
    ]
    expected = pd.concat([pd.DataFrame(part) for part in parts], ignore_index=True)
    pd.testing.assert_frame_equal(frame_written(stacked(parts)), expected)


def test_columns_of_different_lengths_are_refused():
    with pytest.raises(ValueError, match="zip"):
        csv_text({"a": [1, 2], "b": [1]})
    with pytest.raises(ValueError, match="length"):
        npz_bytes({"a": [1, 2], "b": [1]})


def test_single_values_alone_are_one_row():
    assert {name: list(values) for name, values in filled({"a": "x", "b": 2}).items()} == {"a": ["x"], "b": [2]}


def test_nothing_of_pandas_is_imported():
    code = (
        "import sys, numpy as np\nfrom pathlib import Path\n"
        "from tuner.store.columns import in_codes\nfrom tuner.store.npz import npz_bytes\n"
        "from tuner.store.tables import TableFile\n"
        "table = {'a': ['x', 'y'], 'b': np.ones(2), 'c': np.ones((2, 3)), 'd': np.ones(2) > 0, 'e': in_codes(['x', 'y'])}\n"
        "found = TableFile(Path('a.npz'), npz_bytes(table))\n"
        "print([found.column(name) for name in found.names] and [m for m in ('pandas', 'pyarrow') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
