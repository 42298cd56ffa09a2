"""The tables that an inference has and a contest has not."""

from typing import Annotated

from pydantic import Field

from tuner.study.contest_schema import Names
from tuner.study.schema import Table
from tuner.study.size import MOST_FLIGHTS


class UnknownTable(Table):
    """[[unknown]]: a value that a paper leaves open; `tuner.study.unknown_paths` tells what a path is."""

    name: str
    """Name in tables and charts."""
    unit: str
    """Unit of the value."""
    set: list[str]
    """Dotted paths of the study that take the value."""
    low: float
    """Lower end of the range."""
    high: float
    """Upper end of the range."""
    scale: str = "linear"
    """Scale of the range: "linear" or "log"."""


class SettingsTable(Table):
    """[inference]: how the unknowns are searched and judged."""

    contenders: Names | None = None
    """Contenders whose published cells count; by default all."""
    flights: Annotated[int, Field(ge=8, le=MOST_FLIGHTS)] = 32
    """Flights of every contender under each setting of the search."""
    held_out: Annotated[int, Field(ge=40, le=MOST_FLIGHTS)] = 256
    """Flights of every contender under the settings that are checked at the end."""
    near: Annotated[float, Field(gt=0.0)] = 0.1
    """How much worse than the inferred setting another may be, as a share of the misfit, and still count as near it."""


class InferenceTable(Table):
    """The tables that an inference adds to a contest."""

    unknown: Annotated[list[UnknownTable], Field(min_length=1)]
    inference: SettingsTable = SettingsTable()


ADDED = tuple(InferenceTable.model_fields)
"""Tables of an inference that no contest has."""
