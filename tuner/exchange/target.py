"""Interface of a target: the request for an export, the result, and the options that both directions take.

A target either takes a controller as it is, to its own resolution, or refuses with an `InputError` that names what it cannot
hold. What it adds or lacks beside the gains stands in `Bundle.differences`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from plant.airframes import Airframe
from plant.errors import InputError
from tuner.gains import Controller
from tuner.text.units import after_number

# The option that has a flag of its own.
FIRMWARE = "firmware"


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
class Request:
    """A controller to be exported.

    controller: the gains with their airframe and structure. digest: content hash of the gains.json they come from (64 hex
    digits). settings: a value for each option of the exporter, checked. previous: file in the target's own format, or
    gains.json for targets that hold a whole controller, with what the vehicle flies at present; None if unknown.
    """

    controller: Controller
    digest: str
    settings: Mapping[str, str]
    previous: Path | None = None


@dataclass(frozen=True)
class HeldParameter:
    """One number as the target holds it.

    name, unit: the target's. asked: before rounding; held: after rounding to the target's resolution. low, high: the range
    that the target's documentation allows. usual: the target's default. before: what is on the vehicle, None if nobody said.
    All in the target's unit. kept: our loops have no such thing, so the vehicle's own value stays.
    """

    name: str
    unit: str
    asked: float
    held: float
    low: float
    high: float
    usual: float | None = None
    before: float | None = None
    kept: bool = False


@dataclass(frozen=True)
class GyroFilter:
    """Low-pass of a target between the gyro and its loops.

    name: parameter of the target; cutoff [Hz], 0 for none; known: whether the vehicle's file told it, else the default.
    """

    name: str
    cutoff: float
    known: bool


@dataclass(frozen=True)
class Bundle:
    """The result of an export.

    files, rollback: relative name -> content, to be written into the export's folder; the rollback restores the previous
    gains, or the target's defaults. held: the controller that the target holds after rounding, as one of ours, with which
    margins and metrics are worked out again. differences: one sentence for each thing that the target adds or lacks.
    parameters: every number written, for targets that take parameters. target_version: e.g. "PX4 1.16". gyro: low-pass of the
    target between the gyro and these loops, where it has one. notches: whether the files set those that follow the rotors.
    """

    files: Mapping[str, bytes]
    rollback: Mapping[str, bytes]
    held: Controller
    differences: tuple[str, ...]
    target_version: str
    parameters: tuple[HeldParameter, ...] = ()
    gyro: GyroFilter | None = None
    notches: bool = False


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
    one sentence, or "". importer: the way back, None where there is none.
    """

    name: str
    title: str
    export: Callable[[Request], Bundle]
    position_laws: tuple[str, ...] = ()
    attitude_laws: tuple[str, ...] = ()
    options: tuple[Option, ...] = ()
    experimental: str = ""
    importer: Importer | None = None


def number(settings: Mapping[str, str], name: str, low: float, high: float, unit: str) -> float:
    """Return an option as a number of that unit; raises InputError where it is none, or outside [low, high]."""
    text, with_unit = settings[name], after_number(unit)
    try:
        value = float(text)
    except ValueError:
        asked = f"a number{'' if unit == '1' else f' in {unit}'}"
        raise InputError(f"given '{text}'; this must be {asked}", key=flag(name)) from None
    if not low <= value <= high:
        raise InputError(f"given {text}{with_unit}; allowed: {low:g} to {high:g}{with_unit}", key=flag(name))
    return value


def flag(name: str) -> str:
    """Return the flag of an option on the command line."""
    return f"--{name}" if name == FIRMWARE else f"--set {name}"
