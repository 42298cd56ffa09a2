"""Channels with their laws by name, for other processes."""

from collections.abc import Iterable
from dataclasses import fields
from typing import Any

from plant.law_registry import law
from plant.model.plan import Channel


def channels_by_name(channels: Iterable[Channel]) -> tuple[dict[str, Any], ...]:
    """Return the fields of each channel, its law by name."""
    return tuple(
        {field.name: getattr(channel, field.name) for field in fields(channel)} | {"law": channel.law.name}
        for channel in channels
    )


def channels_of(named: Iterable[dict[str, Any]]) -> tuple[Channel, ...]:
    """Return the channels of such fields; UnknownNameError if this process has no law of that name."""
    return tuple(Channel(law=law(each["law"]), **{key: each[key] for key in each if key != "law"}) for each in named)
