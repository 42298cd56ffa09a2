"""Fronts that come with the tool: points of general laws in natural units, for searches that start from no earlier run.

They are those of one quadrotor in one wind. Gains of general laws are accelerations and bandwidths, so that they carry over to
other vehicles as far as those turn and climb as fast. `python -m benchmarks.search.shipped_fronts` makes them.
"""

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

from plant.errors import InputError
from plant.input_files import read_input_text
from plant.quadrotor.gains import GROUPS
from tuner.text.sentences import listing

FILE = Path(__file__).parent / "shipped_fronts.json"


class ShippedFront(NamedTuple):
    """Points of a pair of laws, those that add most first; gains by address."""

    attitude: str
    position: str
    points: tuple[Mapping[str, float], ...]

    @property
    def origin(self) -> str:
        """Words on where the points come from."""
        return f"the shipped front of {self.attitude}/{self.position}"


@cache
def shipped_fronts() -> dict[tuple[str, str], ShippedFront]:
    """Return the fronts by attitude and position law."""
    entries = json.loads(read_input_text(FILE))["fronts"]
    fronts = [
        ShippedFront(entry["attitude"], entry["position"], tuple(map(_by_address, entry["points"])))
        for entry in entries
    ]
    return {(front.attitude, front.position): front for front in fronts}


def _by_address(point: Mapping[str, float]) -> dict[str, float]:
    """Return the gains of each axis from those of groups."""
    parts = [(name.partition("."), value) for name, value in point.items()]
    return {f"{axis}.{gain}": value for (group, _, gain), value in parts for axis in GROUPS[group]}


def shipped_front(attitude: str, position: str) -> ShippedFront:
    """Return the front of a pair of laws; InputError where there is none."""
    fronts = shipped_fronts()
    if (attitude, position) not in fronts:
        pairs = listing(f"{one}/{other}" for one, other in fronts)
        raise InputError(
            f"no front of {attitude}/{position} comes with the tool; there are those of {pairs}: name a results folder, or leave "
            "starts out"
        )
    return fronts[attitude, position]
