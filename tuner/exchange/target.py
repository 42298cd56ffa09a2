"""Interface of a target: the request for an export, the result, and the options that both directions take.

Requests and bundles are those of a quadrotor's controller (`Request`, `Bundle`) or of a plant's (`PlantRequest`, `PlantBundle`).
A target either takes a controller as it is, to its own resolution, or refuses with an `InputError` that names what it cannot
hold. Additions and omissions besides the gains are in `Bundle.differences`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Generic, TypeAlias, TypeVar

from plant.errors import InputError
from plant.input_files import ReadableFile
from plant.quadrotor.airframes import Airframe
from tuner.documents.export import FilteredLoop
from tuner.gains import Controller
from tuner.text.units import after_number

if TYPE_CHECKING:
    # A listing of targets does not wait for all that a study of a plant needs.
    from tuner.study.plant_controller import PlantController

# The option that has a flag of its own.
FIRMWARE = "firmware"
C = TypeVar("C", Controller, "PlantController")


@dataclass(frozen=True)
class Option:
    """A choice that an export takes as `--set NAME=VALUE` (or, for "firmware", as --firmware).

    Attributes:
        about: Meaning and unit, one line.
        choices: Allowed values, empty for a number.
        default: Value where nothing is given; None makes the option required.
    """

    name: str
    about: str
    choices: tuple[str, ...] = ()
    default: str | None = None


@dataclass(frozen=True)
class ExportRequest(Generic[C]):
    """A controller to be exported.

    Attributes:
        controller: The gains with what they fly and their structure.
        digest: Content hash of the gains.json they come from (64 hex digits).
        settings: A value for each option of the exporter, checked.
        previous: File with what the vehicle flies at present, in the target's format, or gains.json for targets
            that hold a complete controller; None if unknown.
    """

    controller: C
    digest: str
    settings: Mapping[str, str]
    previous: Path | None = None


@dataclass(frozen=True)
class HeldParameter:
    """One number as the target holds it, in the target's unit.

    Attributes:
        name: The target's name.
        unit: The target's unit.
        unrounded: Value before rounding.
        held: Value after rounding to the target's resolution.
        low: Lower end of the range that the target's documentation allows.
        high: Upper end of that range.
        usual: The target's default.
        before: Value on the vehicle, None if unknown.
        is_unmanaged: Whether our loops have no such thing, so that the vehicle's value stays.
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

    @property
    def fits(self) -> bool:
        """True for a value in its documented range, or unchanged."""
        return self.low <= self.held <= self.high or self.held == self.before


@dataclass(frozen=True)
class GyroFilter:
    """Low-pass of a target between the gyro and its loops.

    name: parameter of the target; cutoff [Hz], 0 for none; is_from_vehicle: of the vehicle's file, else the default; margins:
    function from a controller and the cut-off to the phase margins [rad] of its loops with our filter and the target's.
    """

    name: str
    cutoff: float
    is_from_vehicle: bool
    margins: Callable[[Controller, float], list[FilteredLoop]]


@dataclass(frozen=True)
class ExportBundle(Generic[C]):
    """The result of an export.

    Attributes:
        files: Relative name -> content, to be written into the export's folder.
        rollback: The same of the files that restore the previous gains, or the target's defaults.
        held: The controller that the target holds after rounding, as one of ours, for its margins and metrics.
        differences: One sentence for each thing that the target adds or lacks.
        target_version: Version of the target, e.g. "PX4 1.16".
        parameters: Every number written, for targets that take parameters.
        gyro: Low-pass of the target between the gyro and these loops, where it has one.
        notches: Whether the files set those that follow the rotors.
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
PlantRequest: TypeAlias = ExportRequest["PlantController"]
PlantBundle: TypeAlias = ExportBundle["PlantController"]


@dataclass(frozen=True)
class ImportedController:
    """A controller read from a target's file.

    Attributes:
        controller: The file's gains on the airframe.
        notes: One sentence for each thing taken as default or left out.
        untouched: Names in the file that do not act in these loops.
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
    read: Callable[[ReadableFile, Airframe, Mapping[str, str]], ImportedController]


@dataclass(frozen=True)
class ExportTarget:
    """A target of exports; where its files can be read, a source of imports.

    Attributes:
        export: Return the bundle of a request; InputError where the target cannot hold something. Laws and options are
            checked before.
        position_laws: Names of the position laws that it takes; empty for every law.
        attitude_laws: Names of the attitude laws that it takes; empty for every law.
        experimental: Reason why it is experimental, one sentence, or "".
        importer: The way back, None where there is none.
        export_plant: Export of a plant's controller, None where the target takes none.
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
