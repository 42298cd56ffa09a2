"""Every flight that a run made, so that none is made twice: the memory behind resume, reuse and verification.

flights/NAME-DIGEST.npz: a row for each flight, with the gains it flew, its scenario, the meters, status and end time. The
name holds the digest of the file's bytes, so damage shows: such a file is set aside as *.damaged and its flights are
flown again. Equal flights give equal files, byte for byte.
"""

import hashlib
import json
from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from objectives.flown_system import FlightBatch
from objectives.meters import Meters
from plant.errors import StoreError
from plant.input_files import MAX_TABLE_BYTES, parse_json, read_input
from plant.quadrotor.scenarios import SEARCH
from plant.records import paths
from tuner.store.columns import Coded, Columns
from tuner.store.document import refuse
from tuner.store.folder import Folder
from tuner.store.npz import npz_bytes
from tuner.store.tables import KIND, TableFile, table_files

Array = np.ndarray
FOLDER = "flights"
# Text beside the columns: scenario key, first flight and number of flights of each block of rows.
BLOCKS = "blocks.json"
# Files whose flights are held in memory at a time, and bytes of flights that are gathered before they are written.
HELD, GATHERED = 4, 64_000_000
RESULTS = (*paths(Meters), "status", "end_time")


@dataclass(frozen=True)
class StoredFlights:
    """Consecutive flights of one gains row in one scenario: `count` rows of a file from `row` on, flights from `first` on."""

    file: Path
    row: int
    first: int
    count: int


@dataclass(frozen=True)
class PendingFlights:
    """Flights waiting to be written: results (n, flights, rows) of gains rows (n, g)."""

    key: str
    batch: FlightBatch
    gains: Array
    first: int
    results: Array


class FlightStore:
    """Store of flights that reads several results folders and writes the first.

    columns: names of the gains; results: of the numbers of a flight. damaged: names of files that were set aside, or
    of other folders passed over.
    """

    def __init__(
        self,
        folder: Folder | None,
        columns: tuple[str, ...],
        others: tuple[Path, ...] = (),
        results: tuple[str, ...] = RESULTS,
    ) -> None:
        self._folder = folder
        self._columns = columns
        self._names = results
        self._blocks: dict[tuple[str, bytes], list[StoredFlights]] = {}
        self._held: OrderedDict[Path, Array] = OrderedDict()
        self._waiting: list[PendingFlights] = []
        self._generations = 0
        self.damaged: list[str] = []
        writable = [] if folder is None else [folder.path]
        for place in [*writable, *others]:
            for file, content in intact_files(place, folder if place in writable else None, self.damaged):
                self._index(file, content, place in writable)

    @property
    def generations(self) -> int:
        """Number of generations whose flights were found in the folder."""
        return self._generations

    def recall(self, key: str, gains: Array, first: int, last: int) -> Array | None:
        """Return the results (last - first, rows) of a gains row, None if incomplete."""
        results = self.load_prefix(key, gains, first, last)
        return results if len(results) == last - first else None

    def load_prefix(self, key: str, gains: Array, first: int, last: int) -> Array:
        """Return the results (k, rows) of a gains row before the first gap.

        They begin with flight `first`.
        """
        parts, flight = [np.empty((0, len(self._names)))], first
        for block in self._blocks.get((key, gains.tobytes()), ()):
            if block.first <= flight < min(block.first + block.count, last):
                end = min(last, block.first + block.count)
                start = block.row - block.first
                parts.append(self._results(block.file)[start + flight : start + end])
                flight = end
        return np.concatenate(parts, axis=0)

    def keep(self, key: str, batch: FlightBatch, gains: Array, first: int, results: Array) -> None:
        """Queue flights for the next `commit`, which many of them bring forward."""
        if self._folder is None or not len(gains):
            return
        self._waiting.append(PendingFlights(key, batch, gains.copy(), first, results))
        if sum(part.results.nbytes for part in self._waiting) > GATHERED:
            self.commit(f"part-{batch.stream}")

    def commit(self, name: str) -> None:
        """Write what was kept since the last time under this name; StoreError where it cannot be written."""
        if self._folder is None or not self._waiting:
            return
        content = encoded(self._waiting, self._columns, self._names)
        self._folder.write_bytes(f"{FOLDER}/{name}-{digest_of(content)}{KIND}", content)
        self._waiting = []

    def _index(self, file: Path, content: bytes, writable: bool) -> None:
        self._generations += writable and file.name.startswith(f"{SEARCH}-")
        for key, gains, block in blocks_of(file, content, self._columns, self._names):
            self._blocks.setdefault((key, gains), []).append(block)
            self._blocks[key, gains].sort(key=lambda entry: entry.first)

    def _results(self, file: Path) -> Array:
        if file not in self._held:
            self._held[file] = results_of(file, self._names)
            if len(self._held) > HELD:
                self._held.popitem(last=False)
        return self._held[file]


def intact_files(place: Path, folder: Folder | None, damaged: list[str]) -> Iterator[tuple[Path, bytes]]:
    """Yield the intact flight files of a results folder, with their bytes.

    The names of damaged ones are added to a list.
    folder: the same folder where this process writes it: intact files are taken over there, damaged ones set aside. Raises
    StoreError where a file cannot be read.
    """
    for file in table_files(place / FOLDER):
        try:
            content = read_input(file, MAX_TABLE_BYTES)
        except OSError as error:
            raise StoreError(
                f"{file} cannot be read ({error.strerror}); make the folder's files yours again (chown)"
            ) from error
        intact = file.stem.endswith(digest_of(content))
        if intact and (folder is None or folder.keep(f"{FOLDER}/{file.name}")):
            yield file, content
            continue
        damaged.append(str(file))
        if folder is not None:
            file.replace(file.with_suffix(".damaged"))


def digest_of(content: bytes) -> str:
    """Return the digest of a file's bytes that stands in its name."""
    return hashlib.blake2b(content, digest_size=8).hexdigest()


def encoded(parts: list[PendingFlights], columns: tuple[str, ...], names: tuple[str, ...] = RESULTS) -> bytes:
    """Return flights as the bytes of an .npz file, block after block."""
    shapes = [part.results.shape for part in parts]
    flights = [np.tile(np.arange(part.first, part.first + n), k) for part, (k, n, _) in zip(parts, shapes, strict=True)]
    gains = np.concatenate([np.repeat(part.gains, n, axis=0) for part, (_, n, _) in zip(parts, shapes, strict=True)])
    results = np.concatenate(
        [part.results.reshape(k * n, rows) for part, (k, n, rows) in zip(parts, shapes, strict=True)]
    )
    sizes = [k * n for k, n, _ in shapes]
    table: Columns = {
        "scenario": _repeated([part.batch.spec.name for part in parts], sizes),
        "stream": _repeated([part.batch.stream for part in parts], sizes),
        "flight": np.concatenate(flights),
    }
    table |= {f"gain:{name}": gains[:, i] for i, name in enumerate(columns)}
    table |= {name: results[:, i] for i, name in enumerate(names)}
    blocks = [[part.key, part.first, n] for part, (k, n, _) in zip(parts, shapes, strict=True) for _ in range(k)]
    return npz_bytes(table, **{BLOCKS: json.dumps(blocks)})


def _repeated(names: list[str], counts: list[int]) -> Coded:
    """Return names repeated by their counts, in codes: millions of texts would take their time."""
    categories = list(dict.fromkeys(names))
    codes = np.repeat(np.array([categories.index(name) for name in names], dtype=np.int32), counts)
    return Coded(codes, categories)


def blocks_of(
    file: Path, content: bytes, columns: tuple[str, ...], results: tuple[str, ...] = RESULTS
) -> list[tuple[str, bytes, StoredFlights]]:
    """Return the scenario key, gains bytes and place of a file's blocks.

    None of them where the file holds other gains.
    """
    table = TableFile(file, content)
    names = [f"gain:{name}" for name in columns]
    if not {*names, *results} <= set(table.names):
        return []
    gains = table.block(names)
    blocks, row = [], 0
    try:
        for key, first, count in parse_json(table.note(BLOCKS)):
            blocks.append((key, gains[row].tobytes(), StoredFlights(file, row, first, count)))
            row += count
    except (ValueError, TypeError, IndexError) as error:
        raise refuse(file, f"its blocks of flights are damaged ({error})") from None
    return blocks


def results_of(file: Path, names: tuple[str, ...] = RESULTS) -> Array:
    """Return the results (flights, rows) of a file."""
    return TableFile(file).block(names)
