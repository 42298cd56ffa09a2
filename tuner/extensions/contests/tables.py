"""Tables of contests that no study has."""

from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from plant.texts import PlainTable
from tuner.text.strict_table import StrictTable


def _as_list(value: object) -> object:
    return [value] if isinstance(value, str) else value


Names = Annotated[list[str], BeforeValidator(_as_list), Field(min_length=1)]


class ContenderTable(StrictTable):
    """[[contender]]: a name, and what lies over the tables of the base study, which flies a quadrotor or a plant."""

    name: str
    """Name in tables and charts."""
    airframe: dict[str, Any] | None = None
    """Its own [airframe]."""
    controller: dict[str, Any] | None = None
    """Its own [controller]."""
    channel: dict[str, dict[str, Any]] | list[dict[str, Any]] | None = None
    """Of a plant: keys that lie over those of a [[channel]] by its name, or all channels."""
    gains: dict[str, Any] | None = None
    """Its own [gains]."""
    search: dict[str, Any] | None = None
    """Its own [search]."""
    pick: dict[str, Any] | None = None
    """Its own [pick]."""

    def tables(self) -> PlainTable:
        """Return the contender's own tables."""
        given = {key: getattr(self, key) for key in type(self).model_fields if key != "name"}
        return {key: value for key, value in given.items() if value is not None}


class PublishedTable(StrictTable):
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


class ClaimTable(StrictTable):
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


class HalvingTable(StrictTable):
    """[halving]: searches of contenders in rungs, from each of which the better part goes on."""

    factor: Annotated[int, Field(ge=2)] = 3
    """Of so many contenders one goes on from a rung, to a search that is as many times longer."""
    finalists: Annotated[int, Field(ge=1)] = 1
    """Contenders whose searches are carried to their end, and which are compared."""
    least: Annotated[int | None, Field(ge=1)] = None
    """Generations of the first rung at least; by default 2 where every search has starts, else 4."""


class ContestTable(StrictTable):
    """The tables that a contest adds to a study."""

    contender: Annotated[list[ContenderTable], Field(min_length=1)]
    halving: HalvingTable | None = None
    published: list[PublishedTable] = Field(default=[])
    claim: list[ClaimTable] = Field(default=[])


class ChoicesTable(StrictTable):
    """The tables that choices beside numbers add to a study."""

    choices: dict[str, Any]
    """Values to choose from by the key of the study that takes one, such as "controller.attitude" = ["hybrid", "pid"]."""
    halving: HalvingTable = HalvingTable()


CONTEST_TABLES = tuple(ContestTable.model_fields)
"""Tables of a contest that no study has."""
