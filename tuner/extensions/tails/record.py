"""Folder of a tail: its inputs, every completed replica, and the flights of the design points."""

import io
import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, NamedTuple, Self, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from plant.errors import InputError, StoreError
from plant.input_files import read_input
from tuner.api.flight_setup import FlightSetup
from tuner.extensions.step_records.json_lines import JsonLines
from tuner.extensions.step_records.key_inputs import Inputs
from tuner.extensions.step_records.keyed_folder import KeyedFolder, StepState
from tuner.extensions.tails.estimation.limit_function import Replica
from tuner.extensions.tails.flight_limit import inputs_of, space_of
from tuner.store.document import DocumentPart
from tuner.store.manifest import digest_of

DOCUMENT, REPLICAS = "tail.json", "replicas.jsonl"
TAIL = "tail"
"""Kind of the folder, name of its one step, and stream of flights that are drawn from a vector."""
POINT_SUFFIX = ".npy"
LARGEST_POINT = 100_000_000
"""Bytes of a flight's vector that are read: 300 s at 1 kHz have 60,000,000."""


Share: TypeAlias = Annotated[float, Field(ge=0.0, le=100.0)]
"""Estimate of a probability: that of a ladder is at most 1, and a plan has fewer than 100 ladders."""
Count: TypeAlias = Annotated[int, Field(ge=0, le=10**12)]


class ReplicaLine(DocumentPart):
    """A replica of the estimate of one event.

    Args:
        gains: Number of the gains.
        event: Event as written.
        number: This and the rest but the digest as of `tuner.extensions.tails.estimation.limit_function.Replica`.
        sha256: Digest of the rest: numbers that a hand or a disk changed may contradict each other in any way.
    """

    gains: Count
    event: str
    number: Count
    probability: Share
    ladders: list[Share]
    curve: list[Share]
    evaluations: Count
    sha256: str

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        if self.sha256 != line_digest(self.content()):
            raise ValueError("has another digest")
        return self

    @property
    def replica(self) -> Replica:
        """The replica."""
        return Replica(self.number, self.probability, tuple(self.ladders), tuple(self.curve), self.evaluations)


class Record(NamedTuple):
    """The files of a tail that is being made."""

    folder: KeyedFolder
    lines: JsonLines[ReplicaLine]

    @classmethod
    def begin(cls, path: Path, inputs: Inputs) -> "Record":
        """Make the folder of a tail, or go on with it; StoreError where it holds another one."""
        folder = KeyedFolder.begin(path, TAIL)
        try:
            if folder.state(TAIL, inputs, "") == StepState.NEW:
                folder.start(TAIL, inputs, "")
            lines = JsonLines(
                path / REPLICAS, ReplicaLine, "take the line out, and the same command makes that replica again"
            )
        except StoreError:
            folder.folder.close()
            raise
        return cls(folder, lines)

    def completed(self, gains: int, event: str) -> tuple[Replica, ...]:
        """Return the replicas of an estimate that are on record."""
        return tuple(line.replica for line in self.lines.lines if (line.gains, line.event) == (gains, event))

    def keep(self, gains: int, event: str, replica: Replica) -> None:
        """Append a replica, unless it is on record."""
        if all(replica.number != earlier.number for earlier in self.completed(gains, event)):
            content = {
                "gains": gains,
                "event": event,
                "number": replica.number,
                "probability": replica.probability,
                "ladders": list(replica.ladders),
                "curve": list(replica.curve),
                "evaluations": replica.evaluations,
            }
            self.lines.append([ReplicaLine.model_validate({**content, "sha256": line_digest(content)})])


def line_digest(content: Mapping[str, Any]) -> str:
    """Return the digest of a line but for the digest in it."""
    rest = {key: value for key, value in content.items() if key != "sha256"}
    return digest_of(json.dumps(rest, sort_keys=True).encode())


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


def point_setup(flight_setup: FlightSetup, flight: str) -> FlightSetup | None:
    """Return the setup of a flight of a tail, by its name.

    None for the name of another flight. Raises InputError where flights of the scenario are drawn from other vectors.
    """
    normals = read_point(flight)
    if normals is None:
        return None
    system, spec = flight_setup.system, flight_setup.spec
    space = space_of(system, spec)
    if len(normals) != space.dimension:
        raise InputError(
            f"holds {len(normals)} numbers, and a flight of '{spec.name}' is drawn from {space.dimension}; give the tail's "
            "study and scenario",
            key="--flight",
        )
    single = inputs_of(system, spec, space, normals[None])
    return replace(flight_setup, draws=(TAIL, range(1)), single=single)
