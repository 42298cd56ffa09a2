"""Reads an airframe: one of the bundled TOML files by name, or a user's file of the same form by path."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from plant.errors import InputError, UnknownNameError, UnphysicalError
from plant.input_files import given_text
from plant.quadrotor.airframes.geometry import FRAMES, SPINS
from plant.quadrotor.airframes.rules import broken_rules
from plant.quadrotor.airframes.schema import (
    GROUPS,
    OPTIONAL,
    SCALARS,
    Sourced,
    check_together,
    read_flag,
    read_numbers,
    read_text,
)
from plant.quadrotor.airframes.uncertainty import Uncertainty, read_uncertainty
from plant.quadrotor.vehicle import Vehicle
from plant.texts import PlainTable, check_name, check_texts, check_title, toml_table
from plant.vectors import Vec3

_BUNDLED = Path(__file__).parent


@dataclass(frozen=True)
class Airframe:
    """One vehicle as its file describes it.

    Attributes:
        name: the file's stem.
        title: one line for people.
        frame: a key of `geometry.FRAMES`.
        vehicle: the numbers as the kernels read them.
        sources: dotted key -> (value, unit, source) of every number in the file.
        path: the file.
        uncertainty: uncertainty of the numbers, if the file has one.
        gyro_noise: amplitude density of the gyro's white noise [rad/s/sqrt(Hz)], if the file has one.
    """

    name: str
    title: str
    frame: str
    vehicle: Vehicle
    sources: dict[str, Sourced]
    path: Path
    uncertainty: Uncertainty | None = None
    gyro_noise: float | None = None


def names() -> tuple[str, ...]:
    """Return the names of the bundled airframes, sorted."""
    return tuple(sorted(path.stem for path in _BUNDLED.glob("*.toml")))


def load(name_or_path: str | Path, *, allow_unphysical: bool = False) -> Airframe:
    """Return a bundled airframe, or that of a TOML file.

    Args:
        name_or_path: A bundled name ("hummingbird"), or a file: a Path, or a text with "/" or ".toml".
        allow_unphysical: Accept numbers that break `airframes.rules`; the file must say `allow_unphysical = true` too.

    Returns:
        The airframe, every number in SI units with its source.

    Raises:
        UnknownNameError: The name is not bundled.
        InputError: Something is wrong in the file; the message names file and key.
        UnphysicalError: Numbers break rules of physics; the message lists every broken rule.
    """
    path = _located(name_or_path)
    check_name(path.stem, file=path, key="file name")
    table = _parsed(path)
    check_texts(table, file=path)
    title = read_text(table, "title", path)
    check_title(title, file=path, key="title")
    frame = read_text(table, "frame", path, tuple(FRAMES))
    spin = read_text(table, "spin", path, tuple(SPINS))
    sources = read_numbers(table, FRAMES[frame].lengths, path)
    check_together(sources, path)
    vehicle = _vehicle({key: number.value for key, number in sources.items()}, frame, spin)
    _judge(vehicle, path, in_file=read_flag(table, "allow_unphysical", path), by_caller=allow_unphysical)
    uncertainty = read_uncertainty(table, path)
    if _deviation(uncertainty, "thrust_linear") and not vehicle.thrust_linear:
        raise InputError(
            "names thrust_linear, which is missing or 0; give its value", file=path, key="uncertainty.names"
        )
    vehicle = vehicle._replace(dead_time_deviation=_deviation(uncertainty, "dead_time"))
    noise = sources["gyro_noise"].value if "gyro_noise" in sources else None
    return Airframe(path.stem, title, frame, vehicle, sources, path, uncertainty, noise)


def _deviation(uncertainty: Uncertainty | None, name: str) -> float:
    """Return the standard deviation of a number, 0 where none is given."""
    if uncertainty is None or name not in uncertainty.names:
        return 0.0
    return uncertainty.deviations[uncertainty.names.index(name)]


def _located(name_or_path: str | Path) -> Path:
    text = str(name_or_path)
    if isinstance(name_or_path, Path) or text.endswith(".toml") or "/" in text or "\\" in text:
        return Path(name_or_path)
    if text not in names():
        raise UnknownNameError("airframe", text, names())
    return _BUNDLED / f"{text}.toml"


def _parsed(path: Path) -> PlainTable:
    return toml_table(given_text(path, f"give a TOML file or a bundled airframe: {', '.join(names())}"), path)


def _vehicle(values: Mapping[str, float], frame: str, spin: str) -> Vehicle:
    rotors = FRAMES[frame].positions(values)
    numbers: dict[str, Any] = {key: values[key] for key in (*SCALARS, *OPTIONAL) if key in values}
    numbers |= {key: Vec3(values[f"{key}.x"], values[f"{key}.y"], values[f"{key}.z"]) for key in GROUPS}
    return Vehicle(rotor_x=rotors.x, rotor_y=rotors.y, spin=SPINS[spin], **numbers)


def _judge(vehicle: Vehicle, path: Path, *, in_file: bool, by_caller: bool) -> None:
    broken = broken_rules(vehicle)
    if not broken or (in_file and by_caller):
        return
    if in_file:
        remedy = "correct the file, or write allow_unphysical = true in [airframe] of the study too, as at the top of the file"
    elif by_caller:
        remedy = (
            "correct the file, or write allow_unphysical = true at its top, above all tables, as in [airframe] of a study "
            "that flies it"
        )
    else:
        remedy = (
            "correct the file, or write allow_unphysical = true twice: at the top of the file, above all tables, and "
            "in [airframe] of the study"
        )
    raise UnphysicalError(f"no real airframe has these numbers: {'; '.join(broken)}. Remedy: {remedy}", file=path)
