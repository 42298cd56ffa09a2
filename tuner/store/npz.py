"""Tables as .npz files: zip files with an array for each column, as `numpy.load` reads them.

NAME.npy holds numbers or truths (rows,), or rows of numbers (rows, n). Of texts it holds codes (rows,) into NAME.texts.npy or,
where pandas is to make categories of them, NAME.categories.npy. Equal tables give equal bytes: members carry no date, and stand
in the order of the columns. Files may be a stranger's: sizes are checked before memory is taken, and nothing but numbers and
texts is read.
"""

import io
import re
from collections.abc import Mapping
from typing import Any
from zipfile import ZIP_DEFLATED, ZIP_STORED, ZipFile, ZipInfo
from zlib import compress

import numpy as np

from plant.input_files import MAX_TABLE_BYTES
from tuner.store.columns import Coded, filled, in_codes

HEADER = re.compile(
    rb"\x93NUMPY\x01\x00..\{'descr': '([<|](?:b1|[iu][1248]|f[248])|<U\d{1,6})', 'fortran_order': False,"
    rb" 'shape': \((\d{1,18}),(?: (\d{1,18}))?\), \} *\n",
    re.DOTALL,
)
"""Header of an array: type and shape."""
MAX_MEMBERS = 20_000
MAX_LETTER, SURROGATES = 0x10FFFF, 0xD800 >> 11
TEXTS, CATEGORIES = ".texts", ".categories"
# Bytes of which a sample tells whether the rest is worth compressing, which takes 40 ns a byte where nothing repeats.
N_SAMPLE, MAX_PACKED = 2**12, 0.75


def npz_bytes(columns: Mapping[str, Any], **notes: str) -> bytes:
    """Return a table as the bytes of an .npz file; notes: texts next to the columns, by name."""
    arrays, table = {}, filled(columns)
    for name, values in table.items():
        arrays |= _arrays(name, values)
    if len({len(arrays[name]) for name in table}) > 1:
        raise ValueError("columns of a table are of one length")
    sink = io.BytesIO()
    with ZipFile(sink, "w") as file:
        for name, array in arrays.items():
            _add(file, f"{name}.npy", _npy(array))
        for name, text in notes.items():
            _add(file, name, text.encode())
    return sink.getvalue()


def _arrays(name: str, values: Any) -> dict[str, np.ndarray]:
    if isinstance(values, Coded):
        kind = CATEGORIES if values.categorical else TEXTS
        return {name: values.codes, name + kind: np.array(values.names, dtype=str)}
    array = np.asarray(values)
    if array.dtype.kind == "U" or (array.dtype == object and any(isinstance(value, str) for value in array)):
        return _arrays(name, in_codes(array, categorical=False))
    return {name: array.astype(np.float64) if array.dtype == object else array}


def _npy(array: np.ndarray) -> bytes:
    sink = io.BytesIO()
    np.lib.format.write_array(sink, np.ascontiguousarray(array), version=(1, 0), allow_pickle=False)
    return sink.getvalue()


def _add(file: ZipFile, name: str, content: bytes) -> None:
    # Without a date, a system or rights of this machine.
    member = ZipInfo(name)
    member.create_system, member.external_attr = 3, 0o600 << 16
    sample = content[len(content) // 2 :][:N_SAMPLE]
    member.compress_type = ZIP_DEFLATED if len(compress(sample, 1)) < MAX_PACKED * len(sample) else ZIP_STORED
    file.writestr(member, content, compresslevel=1)


class NpzTable:
    """Table in the bytes of an .npz file; columns are read on demand."""

    def __init__(self, content: bytes) -> None:
        # The index of a zip file takes a kilobyte for each member while it is read.
        if content.count(b"PK\x01\x02") > MAX_MEMBERS:
            raise ValueError(f"it has more than {MAX_MEMBERS:,} columns")
        self._zip = ZipFile(io.BytesIO(content))
        self._members = {member.filename: member for member in self._zip.infolist()}
        size = sum(member.file_size for member in self._members.values())
        if size > MAX_TABLE_BYTES:
            raise ValueError(
                f"it unpacks to {size / 2**20:,.0f} MiB; at most {MAX_TABLE_BYTES / 2**20:,.0f} MiB are read"
            )
        arrays = [name.removesuffix(".npy") for name in self._members if name.endswith(".npy")]
        self.names = [name for name in arrays if not _is_list_of(name, arrays)]
        self._rows: int | None = None

    def column(self, name: str) -> np.ndarray | Coded:
        """Return a column: numbers (rows,), rows of numbers (rows, n) or coded texts."""
        values = self._array(name)
        if self._rows not in (None, len(values)):
            raise ValueError(f"its columns have {self._rows} and {len(values)} rows")
        self._rows = len(values)
        for kind in (TEXTS, CATEGORIES):
            if f"{name}{kind}.npy" in self._members:
                return _coded(values, self._array(name + kind), kind == CATEGORIES)
        if values.dtype.kind == "U":
            raise ValueError(f"the texts of '{name}' are not coded")
        return values

    def note(self, name: str) -> str:
        """Return a text next to the columns."""
        return self._content(name).decode()

    def _array(self, name: str) -> np.ndarray:
        content = self._content(f"{name}.npy")
        header = HEADER.match(content)
        if header is None:
            raise ValueError(f"'{name}' is no array of numbers or texts")
        kind, shape = np.dtype(header[1].decode()), [int(part) for part in header.groups()[1:] if part]
        count = shape[0] * (shape[1] if len(shape) > 1 else 1)
        if count * kind.itemsize != len(content) - header.end() or (kind.itemsize == 0 and count):
            raise ValueError(f"'{name}' is not as long as it says")
        values = np.frombuffer(content, kind, count, header.end()) if count else np.empty(0, kind)
        return values.reshape(shape)

    def _content(self, name: str) -> bytes:
        if name not in self._members:
            raise ValueError(f"'{name}' is missing")
        member = self._members[name]
        # Others unpack without a bound.
        if member.compress_type not in (ZIP_STORED, ZIP_DEFLATED):
            raise ValueError(f"'{name}' is packed in another way than by deflating")
        with self._zip.open(member) as source:
            return source.read(member.file_size)


def _is_list_of(name: str, arrays: list[str]) -> bool:
    return any(name.endswith(kind) and name.removesuffix(kind) in arrays for kind in (TEXTS, CATEGORIES))


def _coded(codes: np.ndarray, texts: np.ndarray, categorical: bool) -> Coded:
    if codes.dtype.kind not in "iu" or codes.ndim != 1 or texts.dtype.kind != "U" or texts.ndim != 1:
        raise ValueError("codes of texts are no integers, or have no texts")
    letters = np.frombuffer(texts.tobytes(), "<u4")
    # Beyond Unicode, or halves of pairs, which no file can be written with.
    if ((letters > MAX_LETTER) | (letters >> 11 == SURROGATES)).any():
        raise ValueError("a text holds letters that there are not")
    names = texts.tolist()
    if len(set(names)) != len(names) or (len(codes) and not 0 <= codes.min() <= codes.max() < len(names)):
        raise ValueError("a code has no text, or two codes have one")
    return Coded(codes, names, categorical)
