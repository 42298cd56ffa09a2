"""The brief of a worker that flies an FMU: names and numbers, from which it builds the loop that its parent has.

Laws and records made at run time cannot be pickled. A law of a file is read again from it, where its digest is still the same.
"""

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from objectives.plant_meters import meters_of
from plant.errors import InputError
from plant.fmu.fmu_model import Interface, fmu_model
from plant.laws import LAWS, law
from plant.laws.law import Law
from plant.loop import MeterModel, Timing
from plant.model.closing import PlantLoop, close_plant
from plant.model.plan import Actuator, Channel, LoopPlan
from plant.own_code import run_own_code


@dataclass(frozen=True)
class Brief:
    """All that a worker needs before it is asked for flights.

    folder: of the unpacked FMU. channels: fields of each, its law by name. laws: files of laws of the user's own, by
    digest. patience: seconds after which its parent has given it up.
    """

    interface: Interface
    folder: Path
    channels: tuple[dict[str, Any], ...]
    actuators: tuple[Actuator, ...]
    laws: dict[str, Path]
    timing: Timing
    patience: float


def brief_of(interface: Interface, folder: Path, plan: LoopPlan, timing: Timing, patience: float) -> Brief:
    """Return what a worker is told; InputError where it could not find a law again."""
    channels = tuple({field.name: getattr(each, field.name) for field in fields(each)} for each in plan.channels)
    laws = dict(_file_of(each.law) for each in plan.channels if not _is_found_by_name(each.law))
    named = tuple({**each, "law": each["law"].name} for each in channels)
    return Brief(interface, folder, named, plan.actuators, laws, timing, patience)


def _is_found_by_name(entry: Law) -> bool:
    return LAWS.get(entry.name) is entry and (entry.origin is None or entry.origin.packaged)


def _file_of(entry: Law) -> tuple[str, Path]:
    if LAWS.get(entry.name) is not entry or entry.origin is None:
        raise InputError(
            f"'{entry.name}' is a law of no file, and an FMU flies in processes of its own; write the law to a file",
            key="law",
        )
    return entry.origin.digest, Path(entry.origin.place).absolute()


def loop_of(brief: Brief, meters: MeterModel | None = None) -> PlantLoop:
    """Return the loop of a brief; InputError where the file of a law has changed. meters: by default those of its channels."""
    for digest, file in brief.laws.items():
        code = run_own_code(file)
        if code.digest != digest:
            raise InputError("has changed since the study was read; run the study again", file=file)
        LAWS.add(code.names["LAW"], code.origin)
    channels = tuple(Channel(**{**each, "law": law(each["law"])}) for each in brief.channels)
    plan = LoopPlan(channels, brief.actuators)
    return close_plant(fmu_model(brief.interface), plan, meters or meters_of(plan), brief.timing.control_period)
