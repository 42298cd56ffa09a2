"""gains.json: a tuned controller with every number's unit, the structure it belongs to and where it came from."""

from dataclasses import asdict, dataclass
from math import isfinite
from pathlib import Path
from typing import Any

from plant.airframes import Airframe, load, names
from plant.cascade import Cascade, close_cascade
from plant.errors import InputError, UnknownNameError
from plant.gains import gain_addresses
from plant.laws import law
from plant.nominal import ControlOptions
from plant.texts import json_table
from tuner.study.build import located
from tuner.study.gains import check_value
from tuner.study.magnitude import check_magnitude
from tuner.study.messages import shown
from tuner.study.timing import check_plant_step, timing_of

FORMAT, VERSION = "holdfast-gains", "0.1"


@dataclass(frozen=True)
class Controller:
    """A controller ready to fly: the airframe it is for, its cascade, options, periods [s] and gains in column order."""

    airframe: Airframe
    cascade: Cascade
    options: ControlOptions
    control_period: float
    plant_step: float
    gains: tuple[float, ...]


def to_document(controller: Controller, provenance: dict[str, Any]) -> dict[str, Any]:
    """Return the content of gains.json; provenance: study, objectives and what else tells where the gains come from."""
    options = asdict(controller.options)
    tilt = options.pop("tilt_limit")
    return {
        "format": FORMAT,
        "version": VERSION,
        "airframe": {"name": controller.airframe.name, "title": controller.airframe.title},
        "controller": {
            "position": controller.cascade.position.name,
            "attitude": controller.cascade.attitude.name,
            "control_period": {"value": controller.control_period, "unit": "s"},
            "plant_step": {"value": controller.plant_step, "unit": "s"},
            "tilt_limit": {"value": tilt, "unit": "rad"},
            **options,
        },
        "gains": {
            gain.address: {"value": controller.gains[gain.column], "unit": gain.unit}
            for gain in gain_addresses(controller.cascade)
        },
        **provenance,
    }


def read_gains(path: Path, airframe: str | None = None) -> Controller:
    """Read a gains.json; airframe: bundled name or TOML file that flies instead of its own.

    Raises InputError naming file and key where something is missing or wrong.
    """
    document = _parsed(path)
    if document.get("format") != FORMAT:
        given = f"given {shown(document['format'])}" if "format" in document else "this key is missing"
        message = f"{given}; this must be '{FORMAT}': give the gains.json of a results folder"
        raise InputError(message, file=path, key="format")
    with located(path, "airframe"):
        own = _section(document, "airframe", path)
        flown = _airframe(own, path.parent) if airframe is None else load(airframe)
    structure = _section(document, "controller", path)
    with located(path, "controller"):
        cascade = close_cascade(_law(structure, "position"), _law(structure, "attitude"))
        options = _options(structure)
        timing = timing_of(_number(structure, "control_period", "s"), _number(structure, "plant_step", "s"))
        check_plant_step(timing, flown)
    with located(path, "gains"):
        gains = _gains(_section(document, "gains", path), cascade, timing.control_period)
    return Controller(flown, cascade, options, timing.control_period, timing.plant_step, gains)


def _airframe(table: dict[str, Any], folder: Path) -> Airframe:
    """Return the bundled airframe of that name, or a user's own: the copy that a run keeps in inputs/, or NAME.toml in the
    folder of the gains.
    """
    name = _text(table, "name")
    if name in names():
        return load(name, allow_unphysical=True)
    for file in [*(folder / "inputs").glob("*.toml"), *folder.glob("*.toml")]:
        if file.stem == name:
            return load(file, allow_unphysical=True)
    raise UnknownNameError("airframe", name, names(), key="name")


def _options(structure: dict[str, Any]) -> ControlOptions:
    return ControlOptions(
        attitude_rate=_text(structure, "attitude_rate"),
        position_rate=_text(structure, "position_rate"),
        lag_aware=_flag(structure, "lag_aware"),
        delay=_flag(structure, "delay"),
        tilt_limit=_number(structure, "tilt_limit", "rad"),
    )


def _gains(table: dict[str, Any], cascade: Cascade, control_period: float) -> tuple[float, ...]:
    wanted = gain_addresses(cascade)
    known = {gain.address for gain in wanted}
    for name in table:
        if name not in known:
            raise UnknownNameError("gain", name, known)
    values = [_number(table, gain.address, gain.unit) for gain in wanted]
    for gain, value in zip(wanted, values, strict=True):
        check_value(gain.address, gain, value, control_period)
    return tuple(values)


def _parsed(path: Path) -> dict[str, Any]:
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise InputError("there is no such file; give the gains.json of a results folder", file=path) from None
    except UnicodeDecodeError as error:
        message = f"is not UTF-8 text ({error.reason} at byte {error.start}); give the gains.json of a results folder"
        raise InputError(message, file=path) from None
    except OSError as error:
        message = f"cannot be read ({error.strerror}); give the gains.json of a results folder"
        raise InputError(message, file=path) from None
    return json_table(text, path)


def _section(table: dict[str, Any], key: str, path: Path) -> dict[str, Any]:
    value = table.get(key)
    if not isinstance(value, dict):
        given = f"given {shown(value)}; this must be an object" if key in table else "this object is missing"
        raise InputError(given, file=path, key=key)
    return value


def _law(structure: dict[str, Any], key: str) -> Any:
    try:
        return law(_text(structure, key))
    except UnknownNameError as error:
        raise error.located(key=key) from None


def _text(table: dict[str, Any], key: str) -> str:
    value = _given(table, key)
    if not isinstance(value, str):
        raise InputError(f"given {shown(value)}; this must be a text", key=key)
    return value


def _flag(table: dict[str, Any], key: str) -> bool:
    value = _given(table, key)
    if not isinstance(value, bool):
        raise InputError(f"given {shown(value)}; this must be true or false", key=key)
    return value


def _number(table: dict[str, Any], key: str, unit: str) -> float:
    entry = _given(table, key, f'; write {{"value": ..., "unit": "{unit}"}}')
    if not isinstance(entry, dict):
        raise InputError(f'given {shown(entry)}; write {{"value": ..., "unit": "{unit}"}}', key=key)
    for part in entry:
        if part not in ("value", "unit"):
            raise UnknownNameError("key", part, ("value", "unit"), key=f"{key}.{part}")
    value, given_unit = (_given(entry, part, key=f"{key}.{part}") for part in ("value", "unit"))
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise InputError(f"given {shown(value)}; this must be a finite number", key=f"{key}.value")
    if given_unit != unit:
        raise InputError(f"given unit {shown(given_unit)}; this must be in {unit}", key=f"{key}.unit")
    check_magnitude(value, None, f"{key}.value")
    return float(value)


def _given(table: dict[str, Any], name: str, remedy: str = "", key: str | None = None) -> Any:
    if name not in table:
        raise InputError(f"this key is required and missing{remedy}", key=key or name)
    return table[name]
