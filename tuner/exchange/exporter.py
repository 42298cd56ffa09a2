"""What an exporter is: what it is asked, what it gives back.

An exporter either carries a controller as it is, to the resolution of its target, or refuses with an `InputError` that
names what the target cannot hold. What the target adds or lacks beside the gains is said in `Bundle.lossy`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from tuner.gains import Controller


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
    """What is to be exported.

    controller: the gains with their airframe and structure. digest: content hash of the gains.json they come from (64 hex
    digits). settings: a value for each option of the exporter, checked. previous: file in the target's own format, or
    gains.json for targets that hold a whole controller, with what the vehicle flies at present; None if unknown.
    """

    controller: Controller
    digest: str
    settings: Mapping[str, str]
    previous: Path | None = None


@dataclass(frozen=True)
class Parameter:
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
    """What an exporter gives back.

    files, rollback: relative name -> content, to be written into the export's folder; the rollback restores the previous
    gains, or the target's defaults. held: the controller that the target holds after rounding, as one of ours, with which
    margins and metrics are worked out again. lossy: one sentence for each thing that the target adds or lacks.
    parameters: every number written, for targets that take parameters. target_version: e.g. "PX4 1.16". gyro: low-pass of the
    target between the gyro and these loops, where it has one.
    """

    files: Mapping[str, bytes]
    rollback: Mapping[str, bytes]
    held: Controller
    lossy: tuple[str, ...]
    target_version: str
    parameters: tuple[Parameter, ...] = ()
    gyro: GyroFilter | None = None


@dataclass(frozen=True)
class Exporter:
    """One target.

    position_laws, attitude_laws: names of the laws it carries; empty for every law. carry(request) -> Bundle raises
    InputError where something cannot be carried; laws and options are checked before it is called. experimental: what
    makes it so, one sentence, or "".
    """

    name: str
    title: str
    carry: Callable[[Request], Bundle]
    position_laws: tuple[str, ...] = ()
    attitude_laws: tuple[str, ...] = ()
    options: tuple[Option, ...] = ()
    experimental: str = ""
