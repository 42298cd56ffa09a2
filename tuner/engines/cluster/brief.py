"""The brief of a batch that a worker gets: law names and numbers, never code. It builds the same system from its own sources.

Laws, closed loops and their record types are made at run time and cannot be pickled; what they are made from can. That the
worker's sources make the same of it is asked, not assumed: the scenario key of what it built must be the client's.
"""

from dataclasses import dataclass
from typing import Any

from objectives.memory import scenario_key
from objectives.metrics import parse
from objectives.own_meters import metering
from objectives.system import FlightBatch, System
from plant.backends.processor import Processor, compiled_for
from plant.cascade import close_cascade
from plant.closed_loop import Limits
from plant.errors import InputError
from plant.laws import LAWS, law
from plant.loop import Timing
from plant.nominal import Nominal
from plant.scenarios import ScenarioSpec
from plant.vehicle import Vehicle
from tuner.engines.cluster.machine import Report, differences, machine_report, report_for


@dataclass(frozen=True)
class Brief:
    """All that decides the flights of a batch but gains and index. key: `scenario_key` of it; metered: addresses of metrics
    whose own accumulators run; machine: the client's report; target: what it compiles for.
    """

    key: str
    position: str
    attitude: str
    vehicle: Vehicle
    nominal: Nominal
    limits: Limits
    timing: Timing
    root: int
    spec: ScenarioSpec
    stream: str
    metered: tuple[str, ...]
    machine: Report
    target: Processor


def brief_of(system: System, root: int, batch: FlightBatch) -> Brief:
    """Return what a worker has to know of a batch; InputError where it would not find a law or the reference by its name."""
    for entry in (system.cascade.position, system.cascade.attitude):
        if LAWS.get(entry.name) is not entry or _is_of_a_file(entry):
            raise _not_there("law", entry.name)
    for address in system.metered:
        if _is_of_a_file(address.metric):
            raise _not_there("metric", address.metric.name)
    reference = type(batch.spec.reference)
    if _is_of_a_file(reference):
        raise _not_there("reference", reference.kind)
    return Brief(
        scenario_key(system, root, batch), system.cascade.position.name, system.cascade.attitude.name, system.vehicle,
        system.nominal, system.limits, system.timing, root, batch.spec, batch.stream,
        tuple(address.text for address in system.metered), machine_report(), compiled_for(),
    )  # fmt: skip


def _is_of_a_file(entry: Any) -> bool:
    return entry.origin is not None and not entry.origin.packaged


def _not_there(noun: str, name: str) -> InputError:
    return InputError(
        f"the {noun} '{name}' is of a file of your own, and workers are sent no code; make it a package with an entry point in "
        f"holdfast.{noun}s and install that on every worker, or leave --dask out",
        key="--dask",
    )


def system_of(brief: Brief) -> System:
    """Build the system of a brief; InputError where this machine is unlike the client's and would fly other bits."""
    unlike = differences(brief.machine, {"a worker that joined later": report_for(brief.target)})
    if unlike:
        raise InputError(f"{unlike[0]}; stop it and go on with `tuner resume`", key="--dask")
    cascade = close_cascade(law(brief.position), law(brief.attitude))
    system = metering(
        System(brief.vehicle, cascade, brief.nominal, brief.limits, brief.timing), map(parse, brief.metered)
    )
    if scenario_key(system, brief.root, FlightBatch(brief.spec, brief.stream, 1)) != brief.key:
        # Its sources are the client's, so what differs is a package of laws or references.
        raise InputError(
            f"a worker has another version of the code of '{brief.position}', '{brief.attitude}' or "
            f"'{brief.spec.reference.kind}'; install the same on every worker, and go on with `tuner resume`",
            key="--dask",
        )
    return system
