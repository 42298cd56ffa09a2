"""Loops of a plant with their gains, as a gains.json has them, and held against those of a study.

A gains.json tells the loops in the keys of a study's [[channel]] tables, so nothing of the plant's code is needed to read it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field, JsonValue, ValidationError

from objectives.plant_system import PlantSystem
from plant.errors import InputError
from plant.model.plan import Channel
from plant.texts import check_texts
from tuner.gains.parsing import parsed
from tuner.gains.plant_document import VERSION
from tuner.gains.sections import PLANT_FORMAT
from tuner.study.channels import channel_of
from tuner.study.messages import translated
from tuner.study.plant_schema import ChannelTable
from tuner.study.schema import StrictTable
from tuner.text.input_errors import located
from tuner.text.sentences import differing

# What two channels of one name have in common where they are the same controller; who is lost at which error is not theirs.
OF_THE_LAW = ("output", "to", "b0", "rate_output", "every", "low", "high")


class NumberTable(StrictTable):
    """A number with its unit."""

    value: float
    """The number."""
    unit: str
    """UCUM code of its unit, or the unit in braces."""


class TunedLoopsTable(StrictTable):
    """What a gains.json says of the loops of a plant."""

    version: int
    """Version of the format."""
    control_period: NumberTable
    """Period of the controller."""
    channels: Annotated[list[ChannelTable], Field(min_length=1)]
    """Loops, in the keys of a study."""
    gains: dict[str, NumberTable]
    """Gains by address."""


@dataclass(frozen=True)
class TunedLoops:
    """Loops of a plant with their gains. control_period [s]; gains: by address."""

    channels: tuple[Channel, ...]
    control_period: float
    gains: Mapping[str, float]

    def row(self, system: PlantSystem, origin: Path | None) -> np.ndarray:
        """Return the gains row (g,) of a system with these channels; InputError where one is missing. origin: who gives them."""
        for gain in system.gains:
            if gain.address not in self.gains:
                raise InputError(
                    "no number is given for this gain of the study's channels; give the gains.json of a run with these channels",
                    file=origin,
                    key=f"gains.{gain.address}",
                )
        return np.array([self.gains[gain.address] for gain in system.gains])


def loops_of(system: PlantSystem, row: np.ndarray) -> TunedLoops:
    """Return the loops of a system with a gains row (g,)."""
    gains = {gain.address: float(row[gain.column]) for gain in system.gains}
    return TunedLoops(system.plan.channels, system.timing.control_period, gains)


def read_tuned_loops(file: Path) -> TunedLoops:
    """Read the gains.json of a plant; InputError names file and key."""
    return tuned_loops_of(parsed(file), file)


def tuned_loops_of(document: Mapping[str, JsonValue], file: Path | None) -> TunedLoops:
    """Return the loops of the content of a gains.json; file: which, for errors."""
    if document.get("format") != PLANT_FORMAT:
        raise InputError(
            "holds no gains of a plant of one's own; give the gains.json of a run of one", file=file, key="format"
        )
    given = {key: document[key] for key in TunedLoopsTable.model_fields if key in document}
    check_texts(given, file=file)
    try:
        table = TunedLoopsTable.model_validate(given)
    except ValidationError as error:
        raise translated(error, file or Path("gains.json"), TunedLoopsTable) from None
    if table.version != VERSION:
        raise InputError(f"given {table.version}; this holdfast reads version {VERSION}", file=file, key="version")
    channels = []
    for i, entry in enumerate(table.channels):
        with located(file, f"channels[{i}]"):
            channels.append(channel_of(entry))
    return TunedLoops(
        tuple(channels), table.control_period.value, {address: entry.value for address, entry in table.gains.items()}
    )


def read_plant_row(file: Path, system: PlantSystem) -> np.ndarray:
    """Return the gains row (g,) that a gains.json holds for the loops of a system.

    Raises InputError with all that differs where its loops are others, for the same numbers would mean something else in them.
    """
    return row_in(read_tuned_loops(file), system, file)


def row_in(loops: TunedLoops, system: PlantSystem, file: Path | None) -> np.ndarray:
    """Return the gains row (g,) of loops in a system; InputError where its loops are others. file: of the gains, for errors."""
    others = differences(loops, system)
    if others:
        raise InputError(
            f"its loops are not those of the study: {'; '.join(others)}; give a study of these loops, or gains of those",
            file=file,
            key="channels",
        )
    return loops.row(system, file)


def differences(loops: TunedLoops, system: PlantSystem) -> list[str]:
    """Return in what loops differ from those of a system, each as "NAME 'gains' instead of 'study'"."""
    mine, its = {each.name: each for each in loops.channels}, {each.name: each for each in system.plan.channels}
    if set(mine) != set(its):
        return [f"channels {', '.join(mine)} instead of {', '.join(its)}"]
    pairs: list[tuple[str, object, object]] = [
        ("control_period [s]", loops.control_period, system.timing.control_period)
    ]
    for name, channel in mine.items():
        other = its[name]
        pairs.append((f"{name}.law", channel.law.name, other.law.name))
        pairs += [(f"{name}.{key}", getattr(channel, key), getattr(other, key)) for key in OF_THE_LAW]
    return differing(pairs)
