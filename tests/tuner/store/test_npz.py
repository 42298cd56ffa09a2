"""Tables as .npz files: equal bytes for equal tables, and one sentence for whatever a stranger's file holds."""

import io
import os
import struct
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import numpy as np
import pytest

from plant.errors import StoreError
from plant.input_files import MAX_TABLE_BYTES
from tuner.store.columns import in_codes
from tuner.store.npz import npz_bytes
from tuner.store.tables import TableFile

TABLE = {"name": ["b", "a", "b"], "value": np.array([1.0, np.nan, 3.0]), "rows": np.arange(6).reshape(3, 2)}


def opened(content):
    return TableFile(Path("some.npz"), content)


def packed(members, method=zipfile.ZIP_DEFLATED):
    """The bytes of a zip file of members by name."""
    sink = io.BytesIO()
    with zipfile.ZipFile(sink, "w", method) as file:
        for name, content in members.items():
            file.writestr(name, content)
    return sink.getvalue()


def array(values, **options):
    sink = io.BytesIO()
    np.lib.format.write_array(sink, np.asarray(values), **options)
    return sink.getvalue()


def headed(shape, content=b"", kind="'<f8'", order=False):
    """An array file with a header of its own making."""
    text = f"{{'descr': {kind}, 'fortran_order': {order}, 'shape': {shape}, }}\n".encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text + content


def test_equal_tables_are_equal_bytes_on_another_day(monkeypatch):
    first = npz_bytes(TABLE)
    monkeypatch.setattr(time, "time", lambda: 2e9)
    monkeypatch.setattr(os, "umask", lambda mask: 0)
    assert npz_bytes(dict(TABLE)) == first
    assert npz_bytes(dict(reversed(TABLE.items()))) != first


def test_equal_tables_are_equal_bytes_in_another_process():
    code = (
        "import sys, numpy as np\nfrom tuner.store.npz import npz_bytes\n"
        "sys.stdout.buffer.write(npz_bytes({'a': np.random.default_rng(1).normal(size=5000), 'b': ['x'] * 5000}))"
    )
    command = [sys.executable, "-c", code]
    once, again = (
        subprocess.run(
            command, capture_output=True, check=True, env=os.environ | {"TZ": zone, "PYTHONHASHSEED": zone[3]}
        )
        for zone in ("UTC1", "UTC9")
    )
    assert once.stdout == again.stdout != b""


def test_what_does_not_repeat_is_stored_as_it_is():
    noise, steady = np.random.default_rng(1).normal(size=10_000), np.full(10_000, 0.1)
    with zipfile.ZipFile(io.BytesIO(npz_bytes({"noise": noise, "steady": steady}))) as file:
        kinds = {member.filename: member.compress_type for member in file.infolist()}
    assert kinds == {"noise.npy": zipfile.ZIP_STORED, "steady.npy": zipfile.ZIP_DEFLATED}


def test_notes_are_no_columns():
    table = opened(npz_bytes(TABLE, **{"notes.json": "[1]"}))
    assert table.names == list(TABLE) and table.note("notes.json") == "[1]"
    with pytest.raises(StoreError, match="'others.json' is missing"):
        table.note("others.json")


@pytest.mark.parametrize(
    ("members", "complaint"),
    [
        ({"a.npy": b"no array"}, "is no array of numbers or texts"),
        ({"a.npy": array(np.array([{}], dtype=object))}, "is no array of numbers or texts"),
        ({"a.npy": array(np.zeros(1, dtype="V8"))}, "is no array of numbers or texts"),
        ({"a.npy": array(np.zeros(1, dtype="M8[s]"))}, "is no array of numbers or texts"),
        ({"a.npy": array(np.zeros(1, dtype=[("x", "f8")]))}, "is no array of numbers or texts"),
        ({"a.npy": array(np.zeros((2, 2, 2)))}, "is no array of numbers or texts"),
        ({"a.npy": array(np.array(1.0))}, "is no array of numbers or texts"),
        ({"a.npy": headed("(1,)", bytes(8), "__import__('os').abort()")}, "is no array of numbers or texts"),
        ({"a.npy": headed("(-1,)")}, "is no array of numbers or texts"),
        ({"a.npy": headed("(2, 1)", bytes(16), order=True)}, "is no array of numbers or texts"),
        ({"a.npy": headed("(999999999999999999,)", bytes(8))}, "not as long as it says"),
        ({"a.npy": headed("(999999999999999999, 999999999999999999)", bytes(8))}, "not as long as it says"),
        ({"a.npy": headed("(1,)", bytes(9))}, "not as long as it says"),
        ({"a.npy": headed("(2,)", bytes(8))}, "not as long as it says"),
        ({"a.npy": headed("(5,)", b"", "'<U0'")}, "not as long as it says"),
        ({"a.npy": array(["x"])}, "texts of 'a' are not coded"),
        ({"a.npy": array([0.0]), "a.texts.npy": array(["x"])}, "codes of texts are no integers"),
        ({"a.npy": array([0]), "a.texts.npy": array([0])}, "or have no texts"),
        ({"a.npy": array([1]), "a.texts.npy": array(["x"])}, "a code has no text"),
        ({"a.npy": array([-1]), "a.texts.npy": array(["x"])}, "a code has no text"),
        ({"a.npy": array([0]), "a.texts.npy": array(["x", "x"])}, "two codes have one"),
        (
            {"a.npy": array([0]), "a.texts.npy": headed("(1,)", b"\xff\xff\xff\xff", "'<U1'")},
            "letters that there are not",
        ),
        (
            {"a.npy": array([0]), "a.texts.npy": headed("(1,)", b"\x00\xd8\x00\x00", "'<U1'")},
            "letters that there are not",
        ),
        (
            {"a.npy": array([0]), "a.texts.npy": headed("(1,)", b"\x00\x00\x11\x00", "'<U1'")},
            "letters that there are not",
        ),
    ],
)
def test_what_is_no_column_is_told_in_one_sentence(members, complaint):
    with pytest.raises(StoreError, match=complaint) as caught:
        opened(packed(members)).column("a")
    assert "some.npz" in str(caught.value) and len(str(caught.value).splitlines()) == 1


def test_columns_of_other_lengths_are_refused():
    table = opened(packed({"a.npy": array([1.0, 2.0]), "b.npy": array([1.0])}))
    with pytest.raises(StoreError, match="its columns have 2 and 1 rows"):
        table.block(["a", "b"])


@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_other_packings_have_no_bound_and_are_refused(method):
    with pytest.raises(StoreError, match="packed in another way"):
        opened(packed({"a.npy": array(np.zeros(9))}, method)).column("a")


def test_a_table_that_unpacks_to_too_much_is_refused_before_it_is_unpacked():
    content = packed({"a.npy": array(np.zeros(9))})
    place = content.index(b"PK\x01\x02") + 24
    forged = content[:place] + struct.pack("<I", MAX_TABLE_BYTES + 1) + content[place + 4 :]
    with pytest.raises(StoreError, match="it unpacks to 2,048 MiB; at most 2,048 MiB are read"):
        opened(forged)


@pytest.mark.parametrize("size", [0, 64, 100])
def test_no_more_is_unpacked_than_the_index_says(size):
    """A member of 80 MB whose index gives a short length."""
    content = packed({"a.npy": array(np.zeros(10_000_000))})
    place = content.index(b"PK\x01\x02") + 24
    forged = content[:place] + struct.pack("<I", size) + content[place + 4 :]
    import tracemalloc

    table = opened(forged)
    tracemalloc.start()
    with pytest.raises(StoreError, match="not a readable table"):
        table.column("a")
    assert tracemalloc.get_traced_memory()[1] < 1_000_000
    tracemalloc.stop()


def test_an_index_of_very_many_members_is_not_read():
    with pytest.raises(StoreError, match="more than 20,000 columns"):
        opened(npz_bytes(TABLE) + b"PK\x01\x02" * 20_001)


def test_whatever_is_changed_in_a_file_ends_in_one_sentence_or_in_a_table():
    """Single bytes and cuts; checksums find what the index does not."""
    whole, rng = npz_bytes(TABLE | {"code": in_codes(["x", "y", "y"])}), np.random.default_rng(7)
    refused = 0
    for _ in range(600):
        spoilt = bytearray(whole)
        spoilt[rng.integers(len(whole))] ^= 1 << rng.integers(8)
        content = bytes(spoilt) if rng.integers(4) else whole[: rng.integers(len(whole))]
        try:
            table = opened(content)
            _ = [table.column(name) for name in table.names]
        except StoreError as error:
            refused += 1
            assert len(str(error).splitlines()) == 1
    assert refused > 300
