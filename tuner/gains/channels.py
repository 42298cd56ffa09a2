"""Loops of a plant as [[channel]] tables."""

from typing import Annotated

from pydantic import Field

from plant.errors import UnknownNameError
from plant.law_registry import law
from plant.model.plan import Channel
from tuner.text.strict_table import StrictTable


class ChannelTable(StrictTable):
    """[[channel]]: a law between an output and an input, or the set point of another channel."""

    name: str
    """Name of the channel, under which its gains, errors and margins are known."""
    law: str
    """Control law."""
    output: str
    """Output that it controls."""
    to: str
    """Input, or channel whose set point it commands."""
    b0: float = 1.0
    """Second derivative of the output for one unit of command, as the controller believes it."""
    rate_output: str | None = None
    """Output that measures the rate of the other one; by default the law works it out."""
    every: Annotated[int, Field(ge=1)] = 1
    """Control periods between its steps."""
    limit: float | None = None
    """Largest |error| of a flight that has not failed, in the unit of the output; needed where a reference is followed."""
    low: float | None = None
    """Lower limit of its command; by default none."""
    high: float | None = None
    """Upper limit of its command; by default none."""


def channel_of(table: ChannelTable) -> Channel:
    """Return a loop as a [[channel]] table describes it; InputError with the key inside the table."""
    try:
        chosen = law(table.law)
    except UnknownNameError as error:
        raise error.located(key="law") from None
    return Channel(law=chosen, **table.model_dump(exclude={"law"}, exclude_none=True))
