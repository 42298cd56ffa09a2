"""Tables of results folders as columns: those of Parquet files of earlier versions as Arrow itself would hand them over."""

import io
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from plant.errors import MissingPackageError, StoreError
from tests.tables import write_rows
from tuner.documents.tables import groups, in_order
from tuner.store.columns import Coded
from tuner.store.tables import TableFile, table_file, table_files

CELLS = [1.5, None, -2.0, float("nan"), None, 6.0, 7.0, None, 9.0]


def stored(table):
    """A table of Arrow as the reader of earlier versions' files has it."""
    sink = io.BytesIO()
    pq.write_table(table, sink)
    return TableFile(Path("some.parquet"), sink.getvalue())


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
    np.testing.assert_array_equal(stored(table).block(table.column_names), np.stack(expected, axis=1))


@pytest.mark.parametrize("kind", [pa.string(), pa.large_string(), pa.dictionary(pa.int8(), pa.string())])
def test_names_are_told_in_order_of_appearance_however_they_are_stored(kind):
    names = ["pitch", "roll", "pitch", "", "yaw", "roll"]
    column = pa.chunked_array([pa.array(part).cast(kind) for part in (names[:2], names[2:])])
    codes, known = in_order(stored(pa.table({"name": column})).coded("name"))
    assert known == ["pitch", "roll", "", "yaw"]
    assert [known[code] for code in codes] == names


def test_names_that_do_not_appear_are_left_out():
    codes, known = in_order(Coded(np.array([3, 1, 3]), ["a", "b", "c", "d"]))
    assert known == ["d", "b"] and codes.tolist() == [0, 1, 0]


def test_a_missing_category_is_refused():
    column = pa.array(["a", None]).dictionary_encode()
    with pytest.raises(StoreError, match="a text is missing"):
        stored(pa.table({"name": column})).coded("name")


def test_rows_of_numbers_are_read_whatever_wrote_them():
    table = stored(pa.table({"curve": [[1.0, 2.0], [3.0, 4.0]]}))
    np.testing.assert_array_equal(table.numbers("curve", rows=True), [[1.0, 2.0], [3.0, 4.0]])
    with pytest.raises(StoreError, match="not a readable table"):
        stored(pa.table({"curve": [[1.0, 2.0], [3.0]]})).column("curve")


@pytest.mark.parametrize("content", [b"", b"PAR1", b"PAR1" + bytes(60) + b"PAR1"])
def test_what_is_no_parquet_file_is_refused(content):
    with pytest.raises(StoreError, match=r"some.parquet: not a readable table \(.+\)"):
        TableFile(Path("some.parquet"), content)


def test_without_pyarrow_a_folder_of_an_earlier_version_says_what_to_install(monkeypatch):
    monkeypatch.setattr("plant.errors.find_spec", lambda name: None)
    with pytest.raises(
        MissingPackageError,
        match=r"earlier version: needs the package pyarrow; install it with: pip install 'pyarrow>=",
    ):
        TableFile(Path("some.parquet"), b"")


def test_a_later_table_stands_for_an_earlier_one(tmp_path):
    for name in ("0000.parquet", "0001.parquet", "0001.npz", "0002.npz", "notes.txt"):
        (tmp_path / name).touch()
    assert [file.name for file in table_files(tmp_path)] == ["0000.parquet", "0001.npz", "0002.npz"]
    assert [table_file(tmp_path, f"000{i}").name for i in range(4)] == [
        "0000.parquet",
        "0001.npz",
        "0002.npz",
        "0003.npz",
    ]


def test_groups_of_rows_share_their_names(tmp_path):
    file = tmp_path / "a.npz"
    assert list(groups(file, ("name",), ("value",))) == []
    write_rows(file, [{"name": "b", "value": 1.0}, {"name": "a", "value": 2.0}, {"name": "b", "value": 3.0}])
    assert [(names, values.tolist()) for names, values in groups(file, ("name",), ("value",))] == [
        (["b"], [[1.0], [3.0]]),
        (["a"], [[2.0]]),
    ]
    with pytest.raises(StoreError, match="the column 'value' holds no text"):
        list(groups(file, ("value",), ("value",)))
    with pytest.raises(StoreError, match="the column 'name' holds no numbers"):
        list(groups(file, ("name",), ("name",)))
    with pytest.raises(StoreError, match="the column 'time' is missing"):
        list(groups(file, ("name",), ("time",)))
