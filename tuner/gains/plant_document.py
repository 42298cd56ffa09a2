"""gains.json of a plant of the user's own: its loops as data, and their gains, each with its unit."""

from pathlib import Path

import numpy as np

from objectives.plant_system import PlantSystem
from plant.input_files import parse_json, read_input_text
from plant.records import flatten, paths
from tuner.gains.quantities import code_or_note, quantity
from tuner.gains.sections import PLANT_FORMAT, Row

VERSION = 1


def plant_gains_document(system: PlantSystem, gains: np.ndarray, digest: str) -> Row:
    """Return the content of gains.json for a gains row (g,); digest: of the plant's file."""
    plant, plan, timing = system.plant, system.plan, system.timing
    parameters = zip(paths(plant.Parameters), flatten(system.parameters), strict=True)
    return {
        "format": PLANT_FORMAT,
        "version": VERSION,
        "plant": {
            "name": plant.name,
            "title": plant.title,
            "digest": digest,
            "parameters": {name: stated(float(value), plant.unit(f"Parameters.{name}")) for name, value in parameters},
        },
        "control_period": quantity(timing.control_period, "s"),
        "plant_step": quantity(timing.plant_step, "s"),
        "actuators": [_finite(vars(actuator)) for actuator in plan.actuators],
        "channels": [_finite({**vars(channel), "law": channel.law.name}) for channel in plan.channels],
        "gains": {gain.address: stated(float(gains[gain.column]), gain.unit) for gain in system.gains},
    }


def is_plant_gains(file: Path) -> bool:
    """Return True for a file with gains of a plant of the user's own."""
    return format_of(file) == PLANT_FORMAT


def format_of(file: Path) -> str | None:
    """Return the format that a JSON file names, None where it names none."""
    try:
        return parse_json(read_input_text(file)).get("format")
    except (OSError, ValueError, AttributeError):
        return None


def stated(value: float, unit: str) -> Row:
    """Return a number with its unit, which may be any of the user's."""
    return {"value": value, "unit": code_or_note(unit)}


def _finite(values: Row) -> Row:
    """Return the finite values; no limit is not written."""
    return {
        key: value for key, value in values.items() if value is not None and value not in (float("inf"), -float("inf"))
    }
