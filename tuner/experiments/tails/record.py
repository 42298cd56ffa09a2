"""Folder of a tail: the question, every completed replica, and the flights of the design points."""

import hashlib
import io
import json
from pathlib import Path
from typing import NamedTuple

import numpy as np

from objectives.tails.limit_function import Replica
from plant.errors import InputError, StoreError
from plant.input_files import read_input
from tuner.store.advice import QUESTION
from tuner.store.document import DocumentPart
from tuner.store.folder import Folder
from tuner.store.json_lines import JsonLines

DOCUMENT, REPLICAS = "tail.json", "replicas.jsonl"
POINT_SUFFIX = ".npy"
LARGEST_POINT = 100_000_000
"""Bytes of a flight's vector that are read: 300 s at 1 kHz have 60,000,000."""


class ReplicaLine(DocumentPart):
    """A replica of the estimate of one event.

    Args:
        gains: Number of the gains.
        event: As written.
        number: This and the rest as of `objectives.tails.limit_function.Replica`.
    """

    gains: int
    event: str
    number: int
    probability: float
    ladders: list[float]
    curve: list[float]
    evaluations: int

    @property
    def replica(self) -> Replica:
        """The replica."""
        return Replica(self.number, self.probability, tuple(self.ladders), tuple(self.curve), self.evaluations)


class Record(NamedTuple):
    """The files of a tail that is being made."""

    folder: Folder
    lines: JsonLines[ReplicaLine]

    @classmethod
    def begin(cls, path: Path, question: str) -> "Record":
        """Make the folder of a question, or go on with it; StoreError where it holds another one."""
        file = path / QUESTION
        if not file.exists():
            folder = Folder.create(path, inside="", empty=True)
            folder.write_text(QUESTION, question)
        else:
            folder = Folder.open(path)
            if read_input(file, LARGEST_POINT).decode() != question:
                folder.close()
                raise StoreError(
                    f"{path} holds a tail of other gains, events or flights; choose another folder with --out, or give its own "
                    "command again"
                )
        lines = JsonLines(
            path / REPLICAS, ReplicaLine, "take the line out, and the same command makes that replica again"
        )
        return cls(folder, lines)

    def completed(self, gains: int, event: str) -> tuple[Replica, ...]:
        """Return the replicas of an estimate that are on record."""
        return tuple(line.replica for line in self.lines.lines if (line.gains, line.event) == (gains, event))

    def keep(self, gains: int, event: str, replica: Replica) -> None:
        """Append a replica, unless it is on record."""
        if all(replica.number != earlier.number for earlier in self.completed(gains, event)):
            line = ReplicaLine(
                gains=gains,
                event=event,
                number=replica.number,
                probability=replica.probability,
                ladders=list(replica.ladders),
                curve=list(replica.curve),
                evaluations=replica.evaluations,
            )
            self.lines.append([line])


def question_of(content: object) -> str:
    """Return the text that tells a question from others."""
    text = json.dumps(content, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest() + "\n"


def point_bytes(normals: np.ndarray) -> bytes:
    """Return a flight's vector as the bytes of its file."""
    out = io.BytesIO()
    np.save(out, normals, allow_pickle=False)
    return out.getvalue()


def read_point(flight: str) -> np.ndarray | None:
    """Return the vector of a flight of a tail, FOLDER/NAME; None for the name of another flight."""
    file = Path(flight + POINT_SUFFIX)
    if not file.exists():
        return None
    try:
        normals = np.load(io.BytesIO(read_input(file, LARGEST_POINT)), allow_pickle=False)
    except (OSError, ValueError, EOFError):
        normals = np.empty(0)
    if normals.ndim != 1 or normals.dtype != float or not len(normals) or not np.isfinite(normals).all():
        raise InputError("holds no flight of a tail", file=file, key="--flight")
    return normals
