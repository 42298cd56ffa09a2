"""Controllers of a quadrotor and of a plant, as gains.json has them."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np
from pydantic import ValidationError

from objectives.margins.steady_state import SteadyState
from objectives.plant_system import PlantSystem
from plant.errors import InputError
from plant.law_registry import law
from plant.model.plan import Channel
from plant.quadrotor.airframes import Airframe
from plant.quadrotor.cascade import Cascade, close_cascade
from plant.quadrotor.gains import default_row
from plant.quadrotor.nominal import ControlOptions
from plant.texts import check_texts
from tuner.gains.channels import channel_of
from tuner.gains.quantities import plain
from tuner.gains.schema import LoopsTable
from tuner.gains.sections import PLANT_FORMAT, PLANT_VERSION, Row
from tuner.text.input_errors import listed
from tuner.text.product import current_format
from tuner.text.sentences import differing
from tuner.text.strict_table import translate_error

# What two channels of one name have in common where they are the same controller; who is lost at which error is not theirs.
OF_THE_LAW = ("output", "to", "b0", "rate_output", "every", "low", "high")


@dataclass(frozen=True)
class VehicleRecord:
    """Parameter file of the vehicle that gains were imported from.

    It is recorded as far as it covers the loops.

    Attributes:
        target, target_version: Names of an exporter.
        file: Its name without the folder.
        sha256: SHA-256 of its bytes (64 hex digits).
        settings: Options of the import.
        parameters: Name -> value in the target's unit.
        untuned: Names of those that our loops cannot carry; an export leaves them as the vehicle has them.
    """

    target: str
    target_version: str
    file: str
    sha256: str
    settings: Mapping[str, str]
    parameters: Mapping[str, float]
    untuned: tuple[str, ...]


@dataclass(frozen=True)
class Controller:
    """A controller ready to fly: the airframe it is for, its cascade, options, periods [s], gains in column order, the vehicle
    that they were imported from, if any, and the steady states besides hover that its study judged it in.
    """

    airframe: Airframe
    cascade: Cascade
    options: ControlOptions
    control_period: float
    plant_step: float
    gains: tuple[float, ...]
    vehicle: VehicleRecord | None = None
    states: tuple[SteadyState, ...] = ()

    @classmethod
    def default(cls, airframe: Airframe, cascade: Cascade) -> Self:
        """Return a cascade with the default gains of its laws."""
        return cls(airframe, cascade, ControlOptions(), 0.004, 0.001, tuple(default_row(cascade, airframe.vehicle)))


class ControllerPart(NamedTuple):
    """Laws and periods [s] of a file that the schema accepts; given: its options by name, in the units of `ControlOptions`."""

    position: str
    attitude: str
    control_period: float
    plant_step: float
    position_every: int
    given: Row

    @classmethod
    def of(cls, block: Row) -> Self:
        """Return the part of a file at the key "controller"."""
        content: Row = {"position_every": 1, **plain(block)}
        given = {name: content[name] for name in ControlOptions.__dataclass_fields__ if name in content}
        return cls(**{name: content[name] for name in cls._fields[:-1]}, given=given)

    @property
    def cascade(self) -> Cascade:
        """Cascade of the laws."""
        return close_cascade(law(self.position), law(self.attitude), self.position_every)

    @property
    def options(self) -> ControlOptions:
        """Options; raises InputError where one is out of range."""
        return ControlOptions(**self.given)


@dataclass(frozen=True)
class TunedLoops:
    """Loops of a plant with their gains. control_period [s]; gains: by address; observer: its title, "" without one."""

    channels: tuple[Channel, ...]
    control_period: float
    gains: Mapping[str, float]
    observer: str = ""

    @classmethod
    def of(cls, system: PlantSystem, row: np.ndarray) -> Self:
        """Return the loops of a system with a gains row (g,)."""
        gains = {gain.address: float(row[gain.column]) for gain in system.gains}
        return cls(system.plan.channels, system.timing.control_period, gains, system.plan.observer_title)

    @classmethod
    def read(cls, document: Row, file: Path | None) -> Self:
        """Return the loops of the content of a gains.json; file: for errors."""
        if current_format(document.get("format")) != PLANT_FORMAT:
            message = "holds no gains of a plant of one's own; give the gains.json of a run of one"
            raise InputError(message, file=file, key="format")
        given = {key: document[key] for key in LoopsTable.model_fields if key in document}
        check_texts(given, file=file)
        try:
            table = LoopsTable.model_validate(given)
        except ValidationError as error:
            raise translate_error(error, file or Path("gains.json"), LoopsTable) from None
        if table.version != PLANT_VERSION:
            message = f"given {table.version}; this gainproof reads version {PLANT_VERSION}"
            raise InputError(message, file=file, key="version")
        channels = tuple(listed("channels", file, table.channels, channel_of))
        gains = {name: entry.value for name, entry in table.gains.items()}
        return cls(channels, table.control_period.value, gains, table.observer)

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

    def checked_row(self, system: PlantSystem, origin: Path | None) -> np.ndarray:
        """Return the gains row (g,) of the same loops in a system.

        Raises InputError with all that differs where its loops are others: the same numbers would mean something else there.
        """
        if others := self.differences(system):
            raise InputError(
                f"its loops are not those of the study: {'; '.join(others)}; give a study of these loops, or gains of those",
                file=origin,
                key="channels",
            )
        return self.row(system, origin)

    def differences(self, system: PlantSystem) -> list[str]:
        """Return differences from a system's loops: "NAME 'gains' instead of 'study'"."""
        mine, its = ({each.name: each for each in channels} for channels in (self.channels, system.plan.channels))
        if set(mine) != set(its):
            return [f"channels {', '.join(mine)} instead of {', '.join(its)}"]
        pairs: list[tuple[str, object, object]] = [
            ("control_period [s]", self.control_period, system.timing.control_period),
            ("observer", self.observer or "none", system.plan.observer_title or "none"),
        ]
        for name, channel in mine.items():
            other = its[name]
            pairs.append((f"{name}.law", channel.law.name, other.law.name))
            pairs += [(f"{name}.{key}", getattr(channel, key), getattr(other, key)) for key in OF_THE_LAW]
        return differing(pairs)
