"""Record of the settings that an inference flew; a resumed one flies none twice.

flights/STREAM-NNNN-DIGEST.npz: a row for each setting with its values as `unknown:NAME`, and its scores and failures, (cells,
flights) laid flat. The name holds the digest of the file's bytes; a file that does not fit it is set aside and flown again.
"""

from pathlib import Path

import numpy as np

from tuner.store.columns import Columns
from tuner.store.flights import FOLDER, digest_of, intact_files
from tuner.store.folder import Folder
from tuner.store.npz import npz_bytes
from tuner.store.tables import KIND, TableFile

Array = np.ndarray


class SettingStore:
    """Store of scores and failures of settings. names: of the unknowns; cells: their number.

    damaged: names of files that were set aside.
    """

    def __init__(self, folder: Folder, names: tuple[str, ...], cells: int) -> None:
        self._folder, self._names, self._cells = folder, names, cells
        self._stored: dict[tuple[str, int, bytes], tuple[Array, Array]] = {}
        self._written = 0
        self.damaged: list[str] = []
        for file, content in intact_files(folder.path, folder, self.damaged):
            self._read(file, content)

    def load(self, stream: str, count: int, values: Array) -> tuple[Array, Array] | None:
        """Return the stored scores and failed (cells, count) of a setting (unknowns,), or None."""
        return self._stored.get((stream, count, values.tobytes()))

    def add(self, stream: str, values: Array, scores: Array, failed: Array) -> None:
        """Write settings (n, unknowns) with scores and failed (n, cells, flights)."""
        table: Columns = {f"unknown:{name}": values[:, i] for i, name in enumerate(self._names)}
        table |= {"scores": scores.reshape(len(values), -1), "failed": failed.reshape(len(values), -1)}
        content = npz_bytes(table)
        self._folder.write_bytes(f"{FOLDER}/{stream}-{self._written:04d}-{digest_of(content)}{KIND}", content)
        self._written += 1

    def _read(self, file: Path, content: bytes) -> None:
        table, stream = TableFile(file, content), file.stem.rsplit("-", 2)[0]
        values = table.block([f"unknown:{name}" for name in self._names])
        scores, failed = (table.numbers(name, rows=True) for name in ("scores", "failed"))
        for row, score, lost in zip(values, scores, failed, strict=True):
            shape = (self._cells, len(score) // self._cells)
            self._stored[stream, shape[1], row.tobytes()] = (score.reshape(shape), lost.reshape(shape).astype(bool))
