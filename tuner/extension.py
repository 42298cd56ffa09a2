"""An extension: a capability in a folder of its own, and the record of all that it adds to the tool.

A package names its records by entry points, those of this wheel like those of a stranger's:

    [project.entry-points."gainproof.extensions"]
    sensitivity = "tuner.extensions.sensitivity.extension:EXTENSION"

A record holds names alone, "module:object", and its module imports nothing but this one: reading all records takes 3 ms, and
what they name is imported when it is used.
"""

import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import Any

from plant.entry_points import entry_points
from plant.errors import InputError, UnknownNameError

GROUP = "gainproof.extensions"
Names = Mapping[str, str]
BUNDLED_NAMES: Mapping[str, Names] = {
    "commands": {
        "adrc": "betaflight_adrc", "approach": "first_flights", "ask": "trials", "autotune": "autotune", "bench": "bench",
        "compare-logs": "log_comparison", "confirm": "first_flights", "cost": "processor_cost", "fit": "plant_fit",
        "identify": "identification", "judge": "judge", "mcp": "agents", "phase-plane": "phase_plane",
        "sensitivity": "sensitivity", "studio": "studio", "tail": "tails", "tell": "trials", "theory": "theory",
    },
    "tables": {
        "choices": "contests", "contender": "contests", "cost": "processor_cost", "disturbance_gain": "disturbance_gains",
        "guarantee": "theory", "observer": "design_rules", "trials": "trials",
    },
    "experiments": {"contest": "contests", "trials": "trials"},
    "schemas": {"choices-study": "contests", "contest-study": "contests", "trials-study": "trials"},
    "documents": {
        "adrc": "betaflight_adrc", "airframe-estimate": "parts_list", "approach": "first_flights", "autotune": "autotune",
        "confirmation": "first_flights",
        "contest": "contests", "contest-plan": "contests", "flight-plan": "flight_plans", "identification": "identification",
        "log-check": "identification", "log-comparison": "log_comparison", "plant-fit": "plant_fit",
        "read-back": "judge", "sensitivity": "sensitivity", "tail": "tails",
    },
    "targets": {
        "ardupilot": "ardupilot", "betaflight": "betaflight", "betaflight_adrc": "betaflight_adrc", "crazyflie": "crazyflie",
        "fmi": "fmi", "matlab": "matlab", "px4": "px4", "ros2": "ros2", "rotorpy": "rotorpy",
    },
    "backends": {"cuda": "cuda", "cuda-float32": "cuda"},
    "designs": {
        "amigo": "design_rules", "herbst": "design_rules", "lambda": "design_rules", "lqr": "design_rules",
        "poles": "design_rules", "simc": "design_rules", "ziegler-nichols": "design_rules",
    },
    "listings": {"firmwares": "autopilots", "theorems": "theory"},
}  # fmt: skip
"""Part -> name -> extension of this wheel that adds it; tables: of a study file. An installation may lack any of them."""


def _none() -> Names:
    return MappingProxyType({})


@dataclass(frozen=True)
class Extension:
    """The record of an extension.

    Attributes:
        name: Name of the extension, that of its folder.
        about: The capability in one sentence.
        requires: Names of the extensions that it imports.
        command_module: Module whose import registers its commands, "" without any.
        commands: Names of its commands.
        api: Name of the Python API -> "module:object".
        documents: Name of a JSON document -> "module:class" of its model.
        folders: "module:class" of each kind of results folder.
        printers: Type of an answer -> "module:function" that prints it.
        figures: Kind of results -> "module:function" that returns its figures.
        panels: Name of a figure of a run -> "module:function" that returns its panels, none where it does not apply.
        sections: Name of a section of a run's page -> "module:function" that returns it.
        studies: Name of a kind of study -> "module:StudyKind".
        experiments: Name of a kind of experiment -> "module:ExperimentKind".
        schemas: Name of a study file's schema -> "module:function" that returns it.
        previews: Kind of study -> "module:function" that returns what `tuner check` shows.
        plans: Kind of study -> "module:function" that returns what `tuner plan` shows.
        results: Kind of results folder -> "module:class" of the Python API.
        shows: Kind of results -> "module:function" that prints them for `tuner show`.
        loss_sections: The same, below the losses of the page.
        flights: Kind of a single flight -> "module:function" that returns the setup of a flight by its name, or None.
        finalists: Name -> "module:ESTIMATOR" of limits that finalists must keep in flights of their own.
        listings: Kind of `tuner list` -> "module:function" that returns its rows.
        sources: Name of a source of parameter files -> "module:SOURCE".
        firmwares: Name of a firmware that flies finalists -> "module:FIRMWARE".
        opinions: Name -> "module:function" that returns an opinion on a run's gains against present ones.
        certificates: "quadrotor" or "plant" -> "module:function" that returns what is proved of it, as rows of its margins.
        requirements: Table of a study -> "module:RequirementKind".
        costs: Name of a processor -> "module:StepCosts" of the control steps on it.
        designs: Name of a method of `tuner design` -> "module:function" that returns a plant study's gains.
        observers: Table of a plant's study -> "module:function" that returns the plan of its loops with an observer.
        targets: Name of an export target -> "module:TARGET".
        backends: Name of --backend -> "module:BACKEND", the device that flies.
        clusters: Option of a run -> "module:function" that connects to the engine of its value.
        companions: Option of `tuner run` -> "module:function" that returns a context around the run of a folder.
        plants: Ending of a file, and key of [plant] -> "module:SOURCE" of the plants in such files.
        templates: First word after `tuner new` -> "module:function" that writes files and returns them.
        watchers: Name -> "module:function" that returns the watcher of calls that name none, or None.
    """

    name: str
    about: str
    requires: tuple[str, ...] = ()
    command_module: str = ""
    commands: tuple[str, ...] = ()
    api: Names = field(default_factory=_none)
    documents: Names = field(default_factory=_none)
    folders: tuple[str, ...] = ()
    printers: Names = field(default_factory=_none)
    figures: Names = field(default_factory=_none)
    panels: Names = field(default_factory=_none)
    sections: Names = field(default_factory=_none)
    studies: Names = field(default_factory=_none)
    experiments: Names = field(default_factory=_none)
    schemas: Names = field(default_factory=_none)
    previews: Names = field(default_factory=_none)
    plans: Names = field(default_factory=_none)
    results: Names = field(default_factory=_none)
    shows: Names = field(default_factory=_none)
    loss_sections: Names = field(default_factory=_none)
    flights: Names = field(default_factory=_none)
    finalists: Names = field(default_factory=_none)
    listings: Names = field(default_factory=_none)
    sources: Names = field(default_factory=_none)
    firmwares: Names = field(default_factory=_none)
    opinions: Names = field(default_factory=_none)
    certificates: Names = field(default_factory=_none)
    requirements: Names = field(default_factory=_none)
    costs: Names = field(default_factory=_none)
    designs: Names = field(default_factory=_none)
    observers: Names = field(default_factory=_none)
    targets: Names = field(default_factory=_none)
    backends: Names = field(default_factory=_none)
    clusters: Names = field(default_factory=_none)
    companions: Names = field(default_factory=_none)
    plants: Names = field(default_factory=_none)
    templates: Names = field(default_factory=_none)
    watchers: Names = field(default_factory=_none)


@cache
def extensions() -> dict[str, Extension]:
    """Return the extensions of all installed packages by name.

    Raises InputError where a record cannot be loaded, two have one name, or one requires another that is not installed.
    """
    records: dict[str, Extension] = {}
    for name, reference in entry_points(GROUP, sys.path):
        try:
            record = load(reference)
        except (ImportError, AttributeError) as error:
            raise InputError(f"the extension {name} = {reference} cannot be loaded: {error}", file=GROUP) from error
        if not isinstance(record, Extension) or record.name != name:
            raise InputError(f"{reference} is no record of an extension with the name {name}", file=GROUP)
        if records.setdefault(name, record) is not record:
            raise InputError(f"two packages have an extension with the name {name}; remove one", file=GROUP)
    for record in records.values():
        for needed in record.requires:
            if needed not in records:
                raise InputError(f"the extension {record.name} requires {needed}, which is not installed", file=GROUP)
    return dict(sorted(records.items()))


def added(part: str) -> dict[str, str]:
    """Return one part of all records, such as "api": names and what they refer to."""
    return {name: reference for entry in extensions().values() for name, reference in getattr(entry, part).items()}


def objects(part: str) -> dict[str, Any]:
    """Return the objects of one part of all records by name."""
    return {name: load(reference) for name, reference in added(part).items()}


def load(reference: str) -> Any:
    """Return the object that "module:object" names."""
    module, _, name = reference.partition(":")
    return getattr(import_module(module), name)


def refuse_lacking(part: str, name: str, *, file: str | Path | None = None, key: str | None = None) -> None:
    """Raise InputError for a name of a bundled extension that is lacking."""
    home = BUNDLED_NAMES[part].get(name)
    if home is not None and home not in extensions():
        raise InputError(
            f"the {part.removesuffix('s')} '{name}' comes with the extension {home} of gainproof, which is not installed; "
            "install gainproof with it, or do without",
            file=file,
            key=key,
        )


def find(part: str, kind: str, name: str) -> Any:
    """Return the object of a name in one part of all records.

    Raises UnknownNameError where no extension has it, InputError where none has any.
    """
    references = added(part)
    if not references:
        raise InputError(
            f"no installed extension adds a {kind}; `tuner list extensions` shows which there are", key=name
        )
    if name not in references:
        raise UnknownNameError(kind, name, references)
    return load(references[name])
