"""References: what the vehicle is asked to do, as checked descriptions that turn into samples for the closed loop.

A new reference is one file with a `ReferenceSpec` and one entry in `REFERENCES`; or a file that a study names.
"""

from collections.abc import Mapping
from operator import attrgetter
from pathlib import Path

from plant.references.figure_eight import FigureEight
from plant.references.helix import Helix
from plant.references.hover import Hover
from plant.references.level import Level
from plant.references.parameters import Parameter, parameters
from plant.references.ramp import Ramp
from plant.references.spec import ReferenceSpec, Track, build
from plant.references.steps import Steps
from plant.references.table import from_table
from plant.references.waypoints import Waypoints
from plant.registry import Registry

__all__ = ["REFERENCES", "Parameter", "ReferenceSpec", "Track", "build", "from_mapping", "parameters"]

REFERENCES: Registry[type[ReferenceSpec]] = Registry(
    "reference", attrgetter("kind"), (Hover, Level, Steps, Ramp, FigureEight, Helix, Waypoints)
)


def from_mapping(mapping: Mapping[str, object], *, base: Path | None = None, key: str = "reference") -> ReferenceSpec:
    """Return the spec of a table like {kind = "steps", x = 1.0}; see `plant.references.table.from_table`."""
    return from_table(REFERENCES, mapping, base, key)
