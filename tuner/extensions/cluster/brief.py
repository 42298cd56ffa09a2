"""The brief of a batch that a worker gets: names and numbers, never code. It builds the same system from its own sources.

Laws, plants, closed loops and their record types are made at run time and cannot be pickled; what they are made from can. That
the worker's sources make the same of it is asked, not assumed: the scenario key of what it built must be the client's. User files
are named by their digests, and their owner gives them to a worker (`own_files`).
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from objectives.flown_system import FlightBatch, FlownSystem, SystemParts
from objectives.memory import scenario_key
from objectives.metrics import parse
from objectives.own_meters import metering
from plant.backends.processor import Processor, compiled_for
from plant.errors import InputError
from plant.law_registry import LAWS
from plant.laws.law import Law
from tuner.extensions.cluster.machine import Report, differences, machine_report, report_for
from tuner.extensions.cluster.own_files import KEY, OwnFile, check_here, own_files_of


@dataclass(frozen=True)
class BatchSpec:
    """All that decides the flights of a batch but gains and index.

    Attributes:
        key: `scenario_key` of the batch.
        machine: The client's report.
        target: Processor that the client compiles for.
        metered: Addresses of metrics whose accumulators run.
        files: Files of the user that it needs.
    """

    key: str
    parts: SystemParts
    root: int
    spec: Any
    stream: str
    metered: tuple[str, ...]
    machine: Report
    target: Processor
    files: tuple[OwnFile, ...]


def brief_of(system: FlownSystem, root: int, batch: FlightBatch) -> BatchSpec:
    """Return a batch's specification for a worker; InputError where it would not find a law by its name."""
    files = own_files_of(system, [batch.spec])
    for entry in system.laws.values():
        _check_name(entry)
    return BatchSpec(
        scenario_key(system, root, batch),
        system.parts,
        root,
        batch.spec,
        batch.stream,
        tuple(address.text for address in system.metered),
        machine_report(),
        compiled_for(),
        tuple(OwnFile(Path(entry.file.name), entry.digest) for entry in files),
    )


def _check_name(entry: Law) -> None:
    if LAWS.get(entry.name) is not (entry.plain or entry):
        raise InputError(
            f"the law '{entry.name}' is known by no name, and workers are sent no code; write it to a file that the study "
            "names, or leave --dask out",
            key=KEY,
        )


def system_of(brief: BatchSpec) -> FlownSystem:
    """Build the system of a brief; InputError where this machine is unlike the client's and would fly other bits."""
    unlike = differences(brief.machine, {"a worker that joined later": report_for(brief.target)})
    if unlike:
        raise InputError(f"{unlike[0]}; stop it and go on with `tuner resume`", key=KEY)
    check_here(brief.files)
    system = brief.parts.system()
    system = metering(system, [parse(text, system.axes) for text in brief.metered])
    if scenario_key(system, brief.root, FlightBatch(brief.spec, brief.stream, 1)) != brief.key:
        # Its sources are the client's, so what differs is a package of laws or references.
        raise InputError(
            "a worker has another version of a package of laws or references; install the same on every worker, and go on with "
            "`tuner resume`",
            key=KEY,
        )
    return system
