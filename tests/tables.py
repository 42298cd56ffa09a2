"""Tables of results folders for tests: read as pandas frames or as rows, written from either, and as earlier versions wrote them."""

import json
from pathlib import Path

import numpy as np
import pandas as pd

from tuner.documents.tables import frame_of
from tuner.documents.tables import read_frame as read_frame
from tuner.store.columns import columns_of, in_codes
from tuner.store.flights import BLOCKS, digest_of
from tuner.store.manifest import digest_at
from tuner.store.npz import npz_bytes
from tuner.store.tables import TableFile


def frame_written(columns):
    """Columns as pandas has them after they were written and read."""
    return frame_of(TableFile(Path("some.npz"), npz_bytes(columns)))


def read_rows(file):
    """The rows of a table as dictionaries; a number that is missing is None, and rows of numbers are lists."""
    return [{name: plain(value) for name, value in row.items()} for row in read_frame(file).to_dict("records")]


def plain(value):
    if isinstance(value, np.ndarray):
        return value.tolist()
    return None if isinstance(value, float) and np.isnan(value) else value


def write_rows(file, rows):
    """Write rows as a table."""
    Path(file).write_bytes(npz_bytes(columns_of(rows)))


def write_frame(file, frame):
    """Write a frame as a table; rows of numbers are of one length."""
    columns = {}
    for name, values in frame.items():
        listed = values.tolist()
        columns[name] = in_codes(listed) if isinstance(values.dtype, pd.CategoricalDtype) else values.to_numpy()
        if listed and isinstance(listed[0], np.ndarray):
            columns[name] = np.stack(listed)
    Path(file).write_bytes(npz_bytes(columns))


def as_an_earlier_version_wrote_it(folder):
    """Make all tables of a folder, its record and its manifest those of version 4, which wrote Parquet."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    for file in sorted(folder.rglob("*.npz")):
        table = pa.Table.from_pandas(read_frame(file), preserve_index=False)
        former = file.with_suffix(".parquet")
        if file.parent.name == "flights":
            table = table.replace_schema_metadata({"blocks": TableFile(file).note(BLOCKS)})
        pq.write_table(table, former)
        if file.parent.name == "flights":
            former.rename(former.with_stem(f"{file.stem.rpartition('-')[0]}-{digest_of(former.read_bytes())}"))
        file.unlink()
    for name, change in (("run.json", {"version": 4}), ("manifest.json", {})):
        if (folder / name).exists():
            content = json.loads((folder / name).read_text()) | change
            if "files" in content and content["files"]:
                paths = [path for path in sorted(folder.rglob("*")) if path.is_file()]
                names = {path.relative_to(folder).as_posix(): path for path in paths}
                kept = {name for name in names if name in content["files"] or name.endswith(".parquet")}
                content["files"] = {name: digest_at(names[name]) for name in sorted(kept)}
            (folder / name).write_text(json.dumps(content))
