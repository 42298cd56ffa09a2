"""The tables that a contest has and a study has not."""

from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from tuner.study.schema import StudyTable, Table

OWN = ("airframe", "controller", "gains", "search", "pick")
"""Tables of a study that a contender may have of its own; the others are the same for all."""
SHARED = tuple(key for key in StudyTable.model_fields if key not in OWN)


def _as_list(value: object) -> object:
    return [value] if isinstance(value, str) else value


Names = Annotated[list[str], BeforeValidator(_as_list), Field(min_length=1)]


class ContenderTable(Table):
    """[[contender]]: a name, and what lies over the tables of the base study."""

    name: str
    """Name in tables and charts."""
    airframe: dict[str, Any] | None = None
    """Its own [airframe]."""
    controller: dict[str, Any] | None = None
    """Its own [controller]."""
    gains: dict[str, Any] | None = None
    """Its own [gains]."""
    search: dict[str, Any] | None = None
    """Its own [search]."""
    pick: dict[str, Any] | None = None
    """Its own [pick]."""

    def tables(self) -> dict[str, Any]:
        """Return the contender's own tables."""
        return {key: getattr(self, key) for key in OWN if getattr(self, key) is not None}


class PublishedTable(Table):
    """[[published]]: a printed number, SI units, of one contender or of several."""

    contender: Names
    """Contender, or list of contenders, that the number is printed for."""
    metric: str
    """Metric that was printed."""
    scenario: str
    """Scenario that it was printed for."""
    value: float
    """Printed number, in SI units."""
    source: str = ""
    """Where it is printed."""
    fitted: bool = False
    """The study was set to meet it, so it proves nothing."""


class ClaimTable(Table):
    """[[claim]]: `better` is lower than each of `than` in each metric of `in`."""

    better: str
    """Contender that is claimed to be better."""
    than: Names
    """Contenders that it is claimed to be better than."""
    metrics: Names = Field(alias="in")
    """Metrics in which it is claimed to be better."""
    scenario: str | None = None
    """Scenario that the claim is about; by default all."""
    text: str = ""
    """The claim in its own words."""


class ContestTable(Table):
    """The tables that a contest adds to a study."""

    contender: Annotated[list[ContenderTable], Field(min_length=1)]
    published: list[PublishedTable] = Field(default=[])
    claim: list[ClaimTable] = Field(default=[])


ADDED = tuple(ContestTable.model_fields)
"""Tables of a contest that no study has."""
ELSEWHERE = ("unknown", "inference")
"""Tables that a contest file may hold for others to read."""
