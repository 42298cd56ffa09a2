"""The tables that an inference has and a contest has not."""

from typing import Annotated

from pydantic import Field

from tuner.study.contest_schema import Names
from tuner.study.schema import Table
from tuner.study.size import MOST_FLIGHTS


class UnknownTable(Table):
    """[[unknown]]: a value that a paper leaves open. set: the dotted paths that take it, see `tuner.study.unknown_paths`."""

    name: str
    unit: str
    set: list[str]
    low: float
    high: float
    scale: str = "linear"


class SettingsTable(Table):
    """[inference]: contenders: those whose published cells count, by default all. flights, held_out: flights of every
    contender under each setting of the search, and under those that are checked at the end. near: how much worse than
    the inferred setting another may be, as a share of the misfit, and still count as near it.
    """

    contenders: Names | None = None
    flights: Annotated[int, Field(ge=8, le=MOST_FLIGHTS)] = 32
    held_out: Annotated[int, Field(ge=40, le=MOST_FLIGHTS)] = 256
    near: Annotated[float, Field(gt=0.0)] = 0.1


class InferenceTable(Table):
    """What an inference adds to a contest."""

    unknown: Annotated[list[UnknownTable], Field(min_length=1)]
    inference: SettingsTable = SettingsTable()


ADDED = tuple(InferenceTable.model_fields)
"""Tables of an inference that no contest has."""
