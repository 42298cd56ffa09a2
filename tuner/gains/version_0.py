"""gains.json of version 0.1: neither the airframe's numbers nor a hash, units in our own spelling.

It held the airframe's name alone; its numbers are those of the copy that a run kept in inputs/, of the bundled airframe of that
name, or of NAME.toml in the folder of the gains.
"""

import tomllib
from pathlib import Path
from typing import Any

from plant.errors import InputError, UnknownNameError
from plant.input_files import read_input_text
from plant.law_registry import LAWS
from plant.quadrotor.airframes import Airframe, load, names
from tuner.gains.airframe_block import airframe_block
from tuner.gains.quantities import UCUM
from tuner.gains.sections import CONVENTIONS, FORMAT, STRUCTURE, VERSION, Row

PERIODS = ("control_period", "plant_step", "tilt_limit")


def brought_up(old: Row, path: Path, airframe: Airframe | None) -> Row:
    """Return a document of version 0.1 as one of `VERSION` without origin.

    airframe: replaces the document's. Errors in it stay for the schema to report. Raises InputError where the
    airframe is unknown.
    """
    flown = airframe or _airframe(old.get("airframe"), path.parent)
    document: Row = {
        "format": FORMAT,
        "version": VERSION,
        "generator": {"name": "gainproof", "version": "0.1"},
        "conventions": CONVENTIONS,
        "airframe": airframe_block(flown),
    }
    if "controller" in old:
        document["controller"] = _controller(old["controller"])
    if "gains" in old:
        gains = old["gains"]
        document["gains"] = {key: _coded(entry) for key, entry in gains.items()} if isinstance(gains, dict) else gains
    return document


def _controller(old: Any) -> Any:
    if not isinstance(old, dict):
        return old
    laws = {loop: LAWS.get(str(old.get(loop))) for loop in ("position", "attitude")}
    sampling = {loop: "" if law is None else law.discretisation for loop, law in laws.items()}
    timed = {key: _coded(old[key]) for key in PERIODS if key in old}
    return {**old, **timed, "structure": STRUCTURE, "discretisation": sampling}


def _coded(entry: Any) -> Any:
    """Return {value, unit} with the unit in UCUM; a unit that is none of ours is left."""
    if not isinstance(entry, dict) or not isinstance(entry.get("unit"), str):
        return entry
    return {**entry, "unit": UCUM.get(entry["unit"], entry["unit"])}


def _airframe(table: Any, folder: Path) -> Airframe:
    if not isinstance(table, dict) or not isinstance(table.get("name"), str):
        given = isinstance(table, dict) and "name" in table
        message = "this must be a text" if given else "this key is required and missing"
        raise InputError(f"{message}; give the name of an airframe", key="airframe.name")
    name = table["name"]
    recorded = [file for file in (folder / "inputs").glob("*.toml") if file.stem == name and _holds_airframe(file)]
    adjacent = [file for file in folder.glob("*.toml") if file.stem == name and name not in names()]
    for file in [*recorded, *adjacent]:
        return load(file, allow_unphysical=True)
    if name in names():
        return load(name, allow_unphysical=True)
    raise UnknownNameError("airframe", name, names(), key="airframe.name")


def _holds_airframe(file: Path) -> bool:
    """Return True for an airframe in inputs/: a study may bear the same name."""
    try:
        return {"frame", "mass"} <= tomllib.loads(read_input_text(file, "utf-8-sig")).keys()
    except (OSError, ValueError, RecursionError):
        return False
