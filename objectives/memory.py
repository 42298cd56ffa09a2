"""Interface of a flight cache, and the keys of its entries.

A flight is a pure function of the model, the system, its scenario and its gains. `scenario_key` names all of that but the
gains: where the key and the gains are equal to the bit, the recorded result is the one that a new flight would have.
"""

import hashlib
import json
import sys
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Protocol

import numpy as np

import objectives.meters
import plant
from objectives.engine import LANES
from objectives.flown_system import FlightBatch, FlownSystem
from plant.backends import processor
from plant.entry_points import DISTRIBUTION, FLIGHT_CODE, LAW_GROUP, entry_points, files_of

# Libraries whose versions can change the bits of a flight.
LIBRARIES = ("numba", "llvmlite", "numpy", "scipy")


class FlightMemory(Protocol):
    """Cache of flight results (flights, rows) by scenario key, gains row and first index."""

    def recall(self, key: str, gains: np.ndarray, first: int, last: int) -> np.ndarray | None:
        """Return the results (last - first, rows) of one gains row (g,), or None if incomplete."""
        ...

    def keep(self, key: str, batch: FlightBatch, gains: np.ndarray, first: int, results: np.ndarray) -> None:
        """Store the results (n, flights, rows) of gains rows (n, g) from flight `first` on."""
        ...

    def commit(self, name: str) -> None:
        """Write down what was kept since the last time, under a name."""
        ...


def flight_code() -> dict[str, Path]:
    """Return the files of extensions that fly, by module and path."""
    groups = (entry_points(group, sys.path, DISTRIBUTION) for group in (FLIGHT_CODE, LAW_GROUP))
    modules = [value.partition(":")[0] for group in groups for _, value in group]
    return {f"{module}/{name}": file for module in modules for name, file in files_of(module).items()}


@cache
def model_key() -> str:
    """Return the hash of a flight's sources and of its compilers.

    Sources are all of `plant`, the meters, and the code that extensions of this distribution fly with.
    """
    digest = hashlib.blake2b(digest_size=12)
    digest.update(" ".join(f"{name}-{version(name)}" for name in LIBRARIES).encode())
    home = Path(next(iter(plant.__path__)))
    for file in [*sorted(home.rglob("*.py")), Path(objectives.meters.__file__)]:
        digest.update(file.name.encode() + b"\0" + file.read_bytes())
    for name, file in sorted(flight_code().items()):
        digest.update(name.encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()


def scenario_key(
    system: FlownSystem, root: int, batch: FlightBatch, arithmetic: str = LANES, model: str | None = None
) -> str:
    """Return the hash of a batch's flights without gains and index.

    It includes the machine's arithmetic.
    model: `model_key` of the sources that flew, by default those at hand.
    """
    content = {
        "model": model or model_key(),
        **system.content(batch.spec),
        "stream": batch.stream,
        "root": root,
        # Also where a card flies: the air is drawn here.
        "machine": processor.arithmetic().label,
    }
    if arithmetic != LANES:
        content["arithmetic"] = arithmetic
    return hashlib.blake2b(json.dumps(content, sort_keys=True, allow_nan=False).encode(), digest_size=12).hexdigest()
