"""Tables that are written without pandas: pandas reads from them what it would have written itself."""

import io
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from tuner.store.arrow import arrow_table, in_codes, parquet_bytes

from tuner.store.columns import columns_of, csv_text, filled, stacked

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
}


@pytest.mark.parametrize("name", TABLES)
def test_csv_is_what_pandas_writes(name):
    expected = pd.DataFrame(TABLES[name]).to_csv(index=False, float_format="%.17g", lineterminator="\n")
    assert csv_text(TABLES[name]) == expected


@pytest.mark.parametrize("name", TABLES)
def test_parquet_holds_what_pandas_writes(name):
    written, mine = io.BytesIO(), io.BytesIO(parquet_bytes(TABLES[name]))
    pd.DataFrame(TABLES[name]).to_parquet(written, index=False)
    here, there = (pq.ParquetFile(file).read().replace_schema_metadata() for file in (mine, written))
    here.validate(full=True)
    assert here.schema == there.schema
    assert here == there
    pd.testing.assert_frame_equal(pd.read_parquet(mine), pd.read_parquet(written))


def test_lists_of_numbers_are_what_pandas_writes():
    curves = [np.array(row, dtype=np.float32) for row in ([0.1, np.nan, 2.0], [3.0, np.inf, 5.0])]
    written = io.BytesIO()
    pd.DataFrame({"curve": curves}).to_parquet(written, index=False)
    there = pq.ParquetFile(written).read().replace_schema_metadata()
    assert pq.ParquetFile(io.BytesIO(parquet_bytes({"curve": curves}))).read() == there


def test_coded_texts_are_the_categories_of_pandas():
    texts = ["x", "roll", "x", "é", "", "roll"]
    written = io.BytesIO()
    pd.DataFrame({"name": pd.Categorical(texts)}).to_parquet(written, index=False)
    found = pq.ParquetFile(io.BytesIO(parquet_bytes({"name": in_codes(texts)}))).read()
    assert found == pq.ParquetFile(written).read().replace_schema_metadata()


@pytest.mark.parametrize("count", [127, 128, 129, 200])
def test_coded_texts_are_read_again_however_many_there_are(count):
    texts = [f"p{i:03d}" for i in range(count)]
    found = arrow_table({"name": in_codes(texts)})
    found.validate(full=True)
    assert found["name"].to_pylist() == texts


def test_tables_are_stacked_as_by_pandas():
    parts = [
        {"name": "a", "value": np.arange(3.0), "flight": np.int32(1), "signal": ["x", "y", "z"]},
        {"name": "b", "value": np.array([np.nan]), "flight": np.int32(2), "signal": ["x"]},
    ]
    expected = pd.concat([pd.DataFrame(part) for part in parts], ignore_index=True)
    pd.testing.assert_frame_equal(pd.read_parquet(io.BytesIO(parquet_bytes(stacked(parts)))), expected)


def test_columns_of_different_lengths_are_refused():
    with pytest.raises(ValueError, match="zip"):
        csv_text({"a": [1, 2], "b": [1]})
    with pytest.raises(ValueError, match="length"):
        parquet_bytes({"a": [1, 2], "b": [1]})


def test_single_values_alone_are_one_row():
    assert {name: list(values) for name, values in filled({"a": "x", "b": 2}).items()} == {"a": ["x"], "b": [2]}


def test_nothing_of_pandas_is_imported():
    code = (
        "import sys, numpy as np\nfrom tuner.store.arrow import in_codes, parquet_bytes\n"
        "table = {'a': ['x', 'y'], 'b': np.ones(2), 'c': np.ones((2, 3)), 'd': np.ones(2) > 0, 'e': in_codes(['x', 'y'])}\n"
        "parquet_bytes(table)\nprint('pandas' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
