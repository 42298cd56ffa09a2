"""start.json: the first generation, so that a resumed run need not design and screen its starting points again."""

import hashlib
import json
from pathlib import Path

import numpy as np

from plant.backends.processor import arithmetic
from plant.input_files import read_input_text
from tuner.store.document import Document
from tuner.store.folder import Folder

FILE = "start.json"


class Start(Document):
    """Content of start.json. points: of the unit cube; machine: arithmetic that they were found with; digest: of the rest."""

    points: list[list[float]]
    warnings: list[str]
    machine: str = ""
    digest: str


def write_start(folder: Folder, points: np.ndarray, warnings: list[str]) -> None:
    """Write the points (n, d) of the first generation and their warnings."""
    start = Start(points=points.tolist(), warnings=warnings, machine=arithmetic().label, digest="")
    folder.write_json(FILE, start.model_copy(update={"digest": _digest(start.content())}))


def read_start(path: Path, dimensions: int) -> tuple[np.ndarray, list[str]] | None:
    """Return the start that `write_start` wrote; None where it is missing, damaged, or of another arithmetic."""
    try:
        start = Start.parse(read_input_text(path / FILE))
    except (OSError, ValueError):
        return None
    if start.digest != _digest(start.content()) or start.machine != arithmetic().label:
        return None
    return np.array(start.points).reshape(-1, dimensions), start.warnings


def _digest(content: dict[str, object]) -> str:
    digested = {key: value for key, value in content.items() if key != "digest"}
    return hashlib.blake2b(json.dumps(digested, sort_keys=True).encode(), digest_size=8).hexdigest()
