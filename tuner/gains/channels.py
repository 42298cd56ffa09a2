"""Loops of a plant as [[channel]] tables."""

from typing import Annotated

from pydantic import AliasChoices, Field

from plant.errors import UnknownNameError
from plant.law_registry import law
from plant.model.plan import Channel
from tuner.text.strict_table import StrictTable


class LoopTable(StrictTable):
    """A law between an output and its input or inner channel."""

    name: str
    """Name of the channel, under which its gains, errors and margins are known."""
    law: str
    """Control law."""
    output: str
    """Output that it controls."""
    to: str
    """Input, or channel whose set point it commands."""
    b0: float = 1.0
    """Second derivative of the output for one unit of command, in the controller's model."""
    rate_output: str | None = None
    """Output that measures the rate of the other one; by default the law works it out."""
    every: Annotated[int, Field(ge=1)] = 1
    """Control periods between its steps."""
    low: float | None = None
    """Lower limit of its command; by default none."""
    high: float | None = None
    """Upper limit of its command; by default none."""


class ChannelTable(LoopTable):
    """A channel of a gains file."""

    limit: float | None = None
    """Largest |error| of a flight that has not failed, in the unit of the output."""


class StudyChannelTable(LoopTable):
    """[[channel]]: a law between an output and an input, or the set point of another channel."""

    # Recorded under its first name, or no recorded run would be the same study.
    lost_beyond: float | None = Field(
        default=None, validation_alias=AliasChoices("lost_beyond", "limit"), serialization_alias="limit"
    )
    """|error| from which on a flight has failed, in the unit of the output; needed where a reference is followed."""


def channel_of(table: LoopTable) -> Channel:
    """Return a loop as a [[channel]] table describes it; InputError with the key inside the table."""
    try:
        chosen = law(table.law)
    except UnknownNameError as error:
        raise error.located(key="law") from None
    return Channel(law=chosen, **table.model_dump(by_alias=True, exclude={"law"}, exclude_none=True))
