"""A study, checked and ready to run."""

import hashlib
import json
from dataclasses import asdict, dataclass, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from objectives.decisions import DecisionSpace
from objectives.problem import Constraint, Objective, System
from plant.airframes import Airframe
from plant.gains import gain_addresses
from plant.nominal import ControlOptions
from plant.scenarios import ScenarioSpec
from tuner.study.schema import StudyTable


@dataclass(frozen=True)
class StudyScenario:
    """A scenario and how many draws of it the search and the held-out check fly."""

    spec: ScenarioSpec
    search: int
    held_out: int


@dataclass(frozen=True)
class SearchSpec:
    """How the gains are looked for."""

    algorithm: str
    population: int
    generations: int
    initial: tuple[str, ...]


@dataclass(frozen=True)
class Study:
    """What is asked: vehicle and controller, what may change, what is flown, what is wanted, how to look and to pick."""

    path: Path
    title: str
    description: str
    seed: int
    airframe: Airframe
    options: ControlOptions
    system: System
    space: DecisionSpace
    scenarios: tuple[StudyScenario, ...]
    objectives: tuple[Objective, ...]
    constraints: tuple[Constraint, ...]
    search: SearchSpec
    pick: str
    table: StudyTable

    @property
    def default_row(self) -> np.ndarray:
        """Gains row (gains,) of the default: default and fixed gains."""
        return np.array(self.space.base)

    def resolved(self) -> dict[str, Any]:
        """Return every value of the study, defaults and airframe numbers included, as JSON-able data."""
        space = self.space
        return {
            **self.table.model_dump(mode="json"),
            "digest": self.digest(),
            "airframe": {
                "name": self.airframe.name,
                "title": self.airframe.title,
                "frame": self.airframe.frame,
                "numbers": {
                    key: {"value": entry.value, "unit": entry.unit, "source": entry.source}
                    for key, entry in self.airframe.sources.items()
                },
            },
            "gains": {gain.address: space.base[gain.column] for gain in gain_addresses(self.system.cascade)},
            "variables": [asdict(variable) for variable in space.variables],
        }

    def digest(self) -> str:
        """Return a hash of everything that decides the result."""
        content = {
            **self.table.model_dump(mode="json"),
            "vehicle": _plain(self.system.vehicle),
            "space": asdict(self.space),
        }
        text = json.dumps(content, sort_keys=True)
        return hashlib.blake2b(text.encode(), digest_size=12).hexdigest()


def _plain(value: Any) -> Any:
    if is_dataclass(value) and not isinstance(value, type):
        return asdict(value)
    return [_plain(part) for part in value] if isinstance(value, tuple) else value
