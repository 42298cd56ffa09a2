"""Reading of a gains.json into a controller of a quadrotor or plant."""

import sys
from pathlib import Path

from objectives.margins.steady_state import SteadyState
from plant.quadrotor.airframes import Airframe, load, names
from plant.quadrotor.gains import gain_addresses
from tuner.gains.airframe_block import airframe_of, numbers_block
from tuner.gains.controller import Controller, ControllerPart, TunedLoops, VehicleRecord
from tuner.gains.examining import Examined, examine
from tuner.gains.parsing import check_identity, parsed
from tuner.gains.quantities import plain
from tuner.gains.sections import Row
from tuner.text.input_errors import located

# Notes that were given already: a command may read a file twice.
_noted: set[str] = set()


def read_gains(path: Path, airframe: str | None = None) -> Controller:
    """Read a gains.json; airframe: bundled name or TOML file that flies instead of its own.

    The airframe's numbers in the file are what flies; where the bundled airframe of its name has others, a note on standard
    error says so. Raises InputError naming file and key where something is missing or wrong, or where the content does not
    have the hash that it gives.
    """
    with located(path, "airframe"):
        other = None if airframe is None else load(airframe, allow_unphysical=True)
    return controller_of(_sound(path, other), other)


def read_loops(path: Path) -> TunedLoops:
    """Read the gains.json of a plant; InputError names file and key."""
    return TunedLoops.read(parsed(path), path)


def content_sha256(path: Path) -> str:
    """Return the content hash of a gains.json, which may lack it; raises InputError as `read_gains` does."""
    return _sound(path).digest


def _sound(path: Path, airframe: Airframe | None = None) -> Examined:
    """Return the file of a quadrotor as read; raises the first thing that is wrong with it."""
    read = examine(path, airframe)
    check_identity(read.given, path)
    if read.problems:
        raise read.problems[0]
    return read


def controller_of(read: Examined, airframe: Airframe | None = None) -> Controller:
    """Return the controller of a file without problems."""
    document = read.document
    structure, vehicle = ControllerPart.of(document["controller"]), document.get("vehicle")
    gains = plain(document["gains"])
    return Controller(
        airframe or _airframe(read),
        structure.cascade,
        structure.options,
        structure.control_period,
        structure.plant_step,
        tuple(gains[gain.address] for gain in gain_addresses(structure.cascade)),
        None if vehicle is None else _record(vehicle),
        tuple(_state(plain(row)) for row in document.get("states", [])),
    )


def _state(row: Row) -> SteadyState:
    vectors: Row = {key: tuple(row[key]) for key in ("velocity", "wind")}
    return SteadyState(**row | vectors)


def _record(block: Row) -> VehicleRecord:
    pairs = {key: {row["name"]: row["value"] for row in block[key]} for key in ("settings", "parameters")}
    given: Row = {key: value for key, value in block.items() if key != "kept"} | pairs
    return VehicleRecord(**given, untuned=tuple(block["kept"]))


def _airframe(read: Examined) -> Airframe:
    """Return the airframe as the file records it; where it is the bundled one of that name, with its sources."""
    recorded = airframe_of(read.document["airframe"], read.path)
    if recorded.name not in names():
        return recorded
    bundled = load(recorded.name, allow_unphysical=True)
    if bundled.vehicle == recorded.vehicle:
        return bundled
    differing = [
        key for key, entry in numbers_block(bundled.vehicle).items() if entry != numbers_block(recorded.vehicle)[key]
    ]
    what = ", ".join(differing) or "place or turn of the rotors"
    _note(
        f"{read.path}: the airframe '{recorded.name}' flies with the numbers of the file; the bundled one has another {what} "
        f"(tuner fly and tuner margins take it with --airframe {recorded.name})"
    )
    return recorded


def _note(text: str) -> None:
    if text not in _noted:
        _noted.add(text)
        print(f"Note: {text}", file=sys.stderr)
