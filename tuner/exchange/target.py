"""Interface of a target: the request for an export, the result, and the options that both directions take.

Requests and bundles are those of a quadrotor's controller (`Request`, `Bundle`) or of a plant's (`PlantRequest`, `PlantBundle`).
A target either takes a controller as it is, to its own resolution, or refuses with an `InputError` that names what it cannot
hold. What it adds or lacks beside the gains stands in `Bundle.differences`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeAlias, TypeVar

from plant.errors import InputError
from plant.quadrotor.airframes import Airframe
from tuner.gains import Controller
from tuner.study.plant_controller import PlantController
from tuner.text.units import after_number

# The option that has a flag of its own.
FIRMWARE = "firmware"
C = TypeVar("C", Controller, PlantController)


@dataclass(frozen=True)
class Option:
    """A choice that an export takes as `--set NAME=VALUE` (or, for "firmware", as --firmware).

    about: meaning and unit, one line. choices: what is allowed, empty where a number is. default: taken where nothing is
    given; None makes the option required.
    """

    name: str
    about: str
    choices: tuple[str, ...] = ()
    default: str | None = None


@dataclass(frozen=True)
class ExportRequest(Generic[C]):
    """A controller to be exported.

    controller: the gains with what they fly and their structure. digest: content hash of the gains.json they come from (64 hex
    digits). settings: a value for each option of the exporter, checked. previous: file in the target's own format, or
    gains.json for targets that hold a whole controller, with what the vehicle flies at present; None if unknown.
    """

    controller: C
    digest: str
    settings: Mapping[str, str]
    previous: Path | None = None


@dataclass(frozen=True)
class HeldParameter:
    """One number as the target holds it.

    name, unit: the target's. unrounded: before rounding; held: after rounding to the target's resolution. low, high: the range
    that the target's documentation allows. usual: the target's default. before: what is on the vehicle, None if nobody said.
    All in the target's unit. is_unmanaged: our loops have no such thing, so the vehicle's value stays.
    """

    name: str
    unit: str
    unrounded: float
    held: float
    low: float
    high: float
    usual: float | None = None
    before: float | None = None
    is_unmanaged: bool = False


@dataclass(frozen=True)
class GyroFilter:
    """Low-pass of a target between the gyro and its loops.

    name: parameter of the target; cutoff [Hz], 0 for none; is_from_vehicle: of the vehicle's file, else the default.
    """

    name: str
    cutoff: float
    is_from_vehicle: bool


@dataclass(frozen=True)
class ExportBundle(Generic[C]):
    """The result of an export.

    files, rollback: relative name -> content, to be written into the export's folder; the rollback restores the previous
    gains, or the target's defaults. held: the controller that the target holds after rounding, as one of ours, with which
    margins and metrics are worked out again. differences: one sentence for each thing that the target adds or lacks.
    parameters: every number written, for targets that take parameters. target_version: e.g. "PX4 1.16". gyro: low-pass of the
    target between the gyro and these loops, where it has one. notches: whether the files set those that follow the rotors.
    """

    files: Mapping[str, bytes]
    rollback: Mapping[str, bytes]
    held: C
    differences: tuple[str, ...]
    target_version: str
    parameters: tuple[HeldParameter, ...] = ()
    gyro: GyroFilter | None = None
    notches: bool = False


Request: TypeAlias = ExportRequest[Controller]
Bundle: TypeAlias = ExportBundle[Controller]
PlantRequest: TypeAlias = ExportRequest[PlantController]
PlantBundle: TypeAlias = ExportBundle[PlantController]


@dataclass(frozen=True)
class ImportedController:
    """controller: what the file's gains are on the airframe; notes: one sentence for each thing taken as default or left out;
    untouched: names in the file of what does not act in these loops.
    """

    controller: Controller
    notes: tuple[str, ...]
    untouched: tuple[str, ...] = ()


@dataclass(frozen=True)
class Importer:
    """The way back of one target. read(file, airframe, settings) raises InputError naming file and parameter; options are checked
    before it is called.
    """

    name: str
    title: str
    options: tuple[Option, ...]
    read: Callable[[Path, Airframe, Mapping[str, str]], ImportedController]


@dataclass(frozen=True)
class ExportTarget:
    """A target of exports, and where its files can be read, a source of imports.

    export(request) -> Bundle raises InputError where the target cannot hold something; laws and options are checked before it
    is called. position_laws, attitude_laws: names of the laws it takes; empty for every law. experimental: what makes it so,
    one sentence, or "". importer: the way back, None where there is none. export_plant: the same of the controller of a plant,
    None where the target takes none.
    """

    name: str
    title: str
    export: Callable[[Request], Bundle]
    position_laws: tuple[str, ...] = ()
    attitude_laws: tuple[str, ...] = ()
    options: tuple[Option, ...] = ()
    experimental: str = ""
    importer: Importer | None = None
    export_plant: Callable[[PlantRequest], PlantBundle] | None = None


def number(settings: Mapping[str, str], name: str, low: float, high: float, unit: str) -> float:
    """Return an option as a number of that unit; raises InputError where it is none, or outside [low, high]."""
    text, with_unit = settings[name], after_number(unit)
    try:
        value = float(text)
    except ValueError:
        expected = f"a number{'' if unit == '1' else f' in {unit}'}"
        raise InputError(f"given '{text}'; this must be {expected}", key=flag(name)) from None
    if not low <= value <= high:
        raise InputError(f"given {text}{with_unit}; allowed: {low:g} to {high:g}{with_unit}", key=flag(name))
    return value


def whole_number(settings: Mapping[str, str], name: str, low: int, high: int) -> int:
    """Return an option as a whole number; raises InputError where it is none, or outside [low, high]."""
    value = number(settings, name, low, high, "1")
    if value != int(value):
        raise InputError(f"given {value:g}; this must be a whole number from {low} to {high}", key=flag(name))
    return int(value)


def flag(name: str) -> str:
    """Return the flag of an option on the command line."""
    return f"--{name}" if name == FIRMWARE else f"--set {name}"
