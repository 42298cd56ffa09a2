"""Loops of a plant from [[channel]] tables, of a study and of a gains.json."""

from math import inf

from plant.errors import UnknownNameError
from plant.law_registry import law
from plant.model.plan import Channel
from tuner.study.plant_schema import ChannelTable


def channel_of(table: ChannelTable) -> Channel:
    """Return a loop as a [[channel]] table describes it; InputError with the key inside the table."""
    try:
        chosen = law(table.law)
    except UnknownNameError as error:
        raise error.located(key="law") from None
    low, high = or_infinite(table.low, table.high)
    return Channel(
        table.name,
        chosen,
        table.output,
        table.to,
        table.b0,
        table.rate_output,
        table.every,
        inf if table.limit is None else table.limit,
        low,
        high,
    )


def or_infinite(low: float | None, high: float | None) -> tuple[float, float]:
    """Return ends of a range, infinite where none is given."""
    return (-inf if low is None else low, inf if high is None else high)
