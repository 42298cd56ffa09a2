"""start.json: the first generation, so that a resumed run need not design and screen its starting points again."""

import hashlib
import json
from pathlib import Path

import numpy as np

from plant.backends.processor import arithmetic
from plant.input_files import read_input_text
from tuner.store.folder import Folder

FILE = "start.json"


def write_start(folder: Folder, points: np.ndarray, warnings: list[str]) -> None:
    """Write the points (n, d) of the first generation and what was said about them."""
    content = {"points": points.tolist(), "warnings": warnings, "machine": arithmetic().label}
    folder.write_json(FILE, content | {"digest": _digest(content)})


def read_start(path: Path, dimensions: int) -> tuple[np.ndarray, list[str]] | None:
    """Return what `write_start` wrote into a results folder; None where it is missing, damaged, or of another arithmetic."""
    try:
        content = json.loads(read_input_text(path / FILE))
        digest = content.pop("digest")
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
    if digest != _digest(content) or content.get("machine") != arithmetic().label:
        return None
    return np.array(content["points"]).reshape(-1, dimensions), content["warnings"]


def _digest(content: dict[str, object]) -> str:
    return hashlib.blake2b(json.dumps(content, sort_keys=True).encode(), digest_size=8).hexdigest()
