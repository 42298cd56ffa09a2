"""gains.json: a tuned controller with every number's unit, the structure it belongs to and where it came from."""

import json
from dataclasses import asdict, dataclass
from math import isfinite
from pathlib import Path
from typing import Any

from plant.airframes import Airframe, load
from plant.cascade import Cascade, close_cascade
from plant.errors import InputError, UnknownNameError
from plant.gains import gain_addresses
from plant.laws import law
from plant.nominal import ControlOptions

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


def read_gains(path: Path) -> Controller:
    """Read a gains.json; raises InputError naming file and key where something is missing or wrong."""
    document = _parsed(path)
    if document.get("format") != FORMAT:
        raise InputError(f"given '{document.get('format')}'; this must be '{FORMAT}'", file=path, key="format")
    structure = _section(document, "controller", path)
    cascade = close_cascade(_law(structure, "position", path), _law(structure, "attitude", path))
    options = ControlOptions(
        attitude_rate=_text(structure, "attitude_rate", path),
        position_rate=_text(structure, "position_rate", path),
        lag_aware=_flag(structure, "lag_aware", path),
        delay=_flag(structure, "delay", path),
        tilt_limit=_number(structure, "controller", "tilt_limit", "rad", path),
    )
    gains = _section(document, "gains", path)
    wanted = gain_addresses(cascade)
    for name in gains:
        if name not in {gain.address for gain in wanted}:
            raise UnknownNameError("gain", name, [gain.address for gain in wanted], file=path, key="gains")
    return Controller(
        airframe=load(_text(_section(document, "airframe", path), "name", path), allow_unphysical=True),
        cascade=cascade,
        options=options,
        control_period=_number(structure, "controller", "control_period", "s", path),
        plant_step=_number(structure, "controller", "plant_step", "s", path),
        gains=tuple(_number(gains, "gains", gain.address, gain.unit, path) for gain in wanted),
    )


def _parsed(path: Path) -> dict[str, Any]:
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError("there is no such file; give the gains.json of a results folder", file=path) from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"the file cannot be read: {error}", file=path) from None
    except json.JSONDecodeError as error:
        raise InputError(f"not JSON: {error.msg} in line {error.lineno}, column {error.colno}", file=path) from None
    if not isinstance(document, dict):
        raise InputError("given no JSON object; give the gains.json of a results folder", file=path)
    return document


def _section(table: dict[str, Any], key: str, path: Path) -> dict[str, Any]:
    value = table.get(key)
    if not isinstance(value, dict):
        raise InputError("this object is missing", file=path, key=key)
    return value


def _law(structure: dict[str, Any], key: str, path: Path) -> Any:
    try:
        return law(_text(structure, key, path))
    except UnknownNameError as error:
        raise error.located(file=path, key=f"controller.{key}") from None


def _text(table: dict[str, Any], key: str, path: Path) -> str:
    value = table.get(key)
    if not isinstance(value, str):
        raise InputError(f"given {value!r}; this must be a text", file=path, key=key)
    return value


def _flag(table: dict[str, Any], key: str, path: Path) -> bool:
    value = table.get(key)
    if not isinstance(value, bool):
        raise InputError(f"given {value!r}; this must be true or false", file=path, key=key)
    return value


def _number(table: dict[str, Any], section: str, name: str, unit: str, path: Path) -> float:
    key = f"{section}.{name}"
    entry = table.get(name)
    if not isinstance(entry, dict) or set(entry) != {"value", "unit"}:
        raise InputError(f'given {entry!r}; write {{"value": ..., "unit": "{unit}"}}', file=path, key=key)
    value = entry["value"]
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not isfinite(value):
        raise InputError(f"given {value!r}; this must be a finite number", file=path, key=key)
    if entry["unit"] != unit:
        raise InputError(f"given unit '{entry['unit']}'; this must be in {unit}", file=path, key=key)
    return float(value)
