"""The brief of a batch that a worker gets: names and numbers, never code. It builds the same system from its own sources.

Laws, plants, closed loops and their record types are made at run time and cannot be pickled; what they are made from can. That
the worker's sources make the same of it is asked, not assumed: the scenario key of what it built must be the client's. Files of
the user's own are told by their digests, and their owner gives them to a worker (`own_files`).
"""

from dataclasses import dataclass, fields
from functools import singledispatch
from pathlib import Path
from typing import Any

from objectives.memory import scenario_key
from objectives.metrics import parse
from objectives.own_meters import metering
from objectives.plant_system import PlantSystem
from objectives.system import FlightBatch, System
from plant.backends.processor import Processor, compiled_for
from plant.cascade import close_cascade
from plant.closed_loop import Limits
from plant.errors import InputError
from plant.laws import LAWS, law
from plant.laws.law import Law
from plant.loop import Timing
from plant.model.plan import Actuator, Channel, plan_loop
from plant.model.plant_model import plant_from
from plant.nominal import Nominal
from plant.own_code import HAVE_RUN
from plant.records import flatten, pack
from plant.vehicle import Vehicle
from tuner.engines.cluster.machine import Report, differences, machine_report, report_for
from tuner.engines.cluster.own_files import KEY, OwnFile, check_here, own_files_of


@dataclass(frozen=True)
class CascadeParts:
    """The parts of a quadrotor's system."""

    position: str
    attitude: str
    position_every: int
    vehicle: Vehicle
    nominal: Nominal
    limits: Limits
    timing: Timing

    def system(self) -> System:
        """Build the system."""
        cascade = close_cascade(law(self.position), law(self.attitude), self.position_every)
        return System(self.vehicle, cascade, self.nominal, self.limits, self.timing)


@dataclass(frozen=True)
class PlantParts:
    """The parts of the system of a plant of the user's own. digest: of its file, which this process has run.

    channels: fields of each, laws by their names. parameters: nominal ones, in the order of the record.
    """

    name: str
    digest: str
    channels: tuple[dict[str, Any], ...]
    actuators: tuple[Actuator, ...]
    parameters: tuple[float, ...]
    timing: Timing

    def system(self) -> PlantSystem:
        """Build the system."""
        code = HAVE_RUN[self.digest]
        plant = plant_from(code.names, self.name, str(code.file))
        channels = [Channel(**{**values, "law": law(values["law"])}) for values in self.channels]
        parameters = pack(plant.Parameters, list(self.parameters))
        return PlantSystem(plant, plan_loop(plant, channels, self.actuators), parameters, self.timing)


@dataclass(frozen=True)
class Brief:
    """All that decides the flights of a batch but gains and index. key: `scenario_key` of it; machine: the client's report;
    target: what it compiles for; metered: addresses of metrics whose own accumulators run; files: of the user's own that it
    needs.
    """

    key: str
    parts: CascadeParts | PlantParts
    root: int
    spec: Any
    stream: str
    metered: tuple[str, ...]
    machine: Report
    target: Processor
    files: tuple[OwnFile, ...]


def brief_of(system: Any, root: int, batch: FlightBatch) -> Brief:
    """Return what a worker has to know of a batch; InputError where it would not find a law by its name."""
    files = own_files_of(system, [batch.spec])
    return Brief(
        scenario_key(system, root, batch), parts_of(system), root, batch.spec, batch.stream,
        tuple(address.text for address in system.metered), machine_report(), compiled_for(),
        tuple(OwnFile(Path(entry.file.name), entry.digest) for entry in files),
    )  # fmt: skip


@singledispatch
def parts_of(system: Any) -> CascadeParts | PlantParts:
    """Return what a system is made from."""
    raise NotImplementedError(type(system))


@parts_of.register
def _(system: System) -> CascadeParts:
    cascade = system.cascade
    return CascadeParts(
        _name_of(cascade.position),
        _name_of(cascade.attitude),
        cascade.position_every,
        system.vehicle,
        system.nominal,
        system.limits,
        system.timing,
    )


@parts_of.register
def _(system: PlantSystem) -> PlantParts:
    (own, *_) = own_files_of(system, [])
    channels = tuple(
        {field.name: getattr(channel, field.name) for field in fields(channel)} | {"law": _name_of(channel.law)}
        for channel in system.plan.channels
    )
    parameters = tuple(float(value) for value in flatten(system.parameters))
    return PlantParts(system.plant.name, own.digest, channels, system.plan.actuators, parameters, system.timing)


def _name_of(entry: Law) -> str:
    if LAWS.get(entry.name) is not (entry.plain or entry):
        raise InputError(
            f"the law '{entry.name}' is known by no name, and workers are sent no code; write it to a file that the study "
            "names, or leave --dask out",
            key=KEY,
        )
    return entry.name


def system_of(brief: Brief) -> Any:
    """Build the system of a brief; InputError where this machine is unlike the client's and would fly other bits."""
    unlike = differences(brief.machine, {"a worker that joined later": report_for(brief.target)})
    if unlike:
        raise InputError(f"{unlike[0]}; stop it and go on with `tuner resume`", key=KEY)
    check_here(brief.files)
    system: Any = brief.parts.system()
    system = metering(system, [parse(text, system.axes) for text in brief.metered])
    if scenario_key(system, brief.root, FlightBatch(brief.spec, brief.stream, 1)) != brief.key:
        # Its sources are the client's, so what differs is a package of laws or references.
        raise InputError(
            "a worker has another version of a package of laws or references; install the same on every worker, and go on with "
            "`tuner resume`",
            key=KEY,
        )
    return system
