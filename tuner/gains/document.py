"""From a controller or a plant's loops to the content of gains.json."""

from collections.abc import Mapping
from dataclasses import asdict
from math import nan

import numpy as np

from objectives.plant_system import PlantSystem
from plant.quadrotor.gains import gain_addresses
from plant.quadrotor.nominal import BATTERY_RANGES, NOTCH_RANGES
from plant.records import flatten, paths
from tuner.gains.airframe_block import airframe_block
from tuner.gains.controller import Controller, VehicleRecord
from tuner.gains.hashing import content_hash
from tuner.gains.quantities import code_or_note, quantity
from tuner.gains.schema import STATE, controller_schema
from tuner.gains.sections import (
    CONVENTIONS,
    FORMAT,
    MAX_EXACT_INTEGER,
    PLANT_FORMAT,
    PLANT_VERSION,
    STRUCTURE,
    VERSION,
    Row,
    add_units,
)
from tuner.text.version import version

Ranges = Mapping[str, tuple[float, float]]

NO_RANGES: Ranges = {}
# Relative.
ROUNDING = 1e-9


def to_document(controller: Controller, provenance: Row, ranges: Ranges = NO_RANGES) -> Row:
    """Return the content of gains.json with its hash.

    provenance: the sections of `sections` that tell where the gains come from, units in UCUM. ranges: address of a gain ->
    ends of the range that a search had for it.
    """
    document: Row = {
        "format": FORMAT,
        "version": VERSION,
        "generator": {"name": "gainproof", "version": version()},
        "conventions": CONVENTIONS,
        "airframe": airframe_block(controller.airframe),
        "controller": controller_block(controller),
        "gains": gains_block(controller, ranges),
        **({} if controller.vehicle is None else {"vehicle": vehicle_block(controller.vehicle)}),
        **({"states": [add_units(STATE, vars(state)) for state in controller.states]} if controller.states else {}),
        **provenance,
    }
    return {**document, "sha256": content_hash(document)}


def controller_block(controller: Controller) -> Row:
    """Return laws, periods, options, structure and how the laws are sampled; options that are off are left out."""
    options, cascade = asdict(controller.options), controller.cascade
    for names in (("yaw_torque_cutoff",), tuple(NOTCH_RANGES), tuple(BATTERY_RANGES)):
        if not options[names[0]]:
            options |= dict.fromkeys(names)
    laws = {"position": cascade.position, "attitude": cascade.attitude}
    # Of laws that are not bundled.
    code = {loop: {"file": law.origin.short, "digest": law.origin.digest} for loop, law in laws.items() if law.origin}
    content = {
        **{loop: law.name for loop, law in laws.items()},
        "control_period": controller.control_period,
        "plant_step": controller.plant_step,
        **options,
        "position_every": None if cascade.position_every == 1 else cascade.position_every,
        "structure": STRUCTURE,
        "discretisation": {loop: law.discretisation for loop, law in laws.items()},
        "code": code or None,
    }
    return add_units(controller_schema(), content)


def vehicle_block(vehicle: VehicleRecord) -> Row:
    """Return the record of the vehicle that gains were imported from."""
    record = asdict(vehicle)
    untuned = record.pop("untuned")
    return {
        **record,
        "settings": [{"name": name, "value": value} for name, value in vehicle.settings.items()],
        "parameters": [{"name": name, "value": value} for name, value in vehicle.parameters.items()],
        "kept": list(untuned),
    }


def gains_block(controller: Controller, ranges: Ranges) -> Row:
    """Return the gains by address."""
    return {
        gain.address: {
            **quantity(controller.gains[gain.column], gain.unit),
            **_range(ranges, gain.address, controller.gains[gain.column]),
        }
        for gain in gain_addresses(controller.cascade)
    }


def within(value: float, low: float, high: float) -> bool:
    """Return True for a gain in a range: to the rounding of a search in its logarithm."""
    return low - ROUNDING * abs(low) <= value <= high + ROUNDING * abs(high)


def _range(ranges: Ranges, address: str, value: float) -> Row:
    """Return the range that a search had for a gain; a default that lies outside was not found in it."""
    low, high = ranges.get(address, (nan, nan))
    return {"low": low, "high": high} if within(value, low, high) else {}


def seed_entry(seed: int) -> int | str:
    """Return a seed as JSON holds it: as text where a double would not tell it from its neighbours."""
    return seed if seed <= MAX_EXACT_INTEGER else str(seed)


def plant_gains_document(system: PlantSystem, gains: np.ndarray, digest: str) -> Row:
    """Return the content of gains.json of a plant for a gains row (g,); digest: of the plant's file."""
    plant, plan, timing = system.plant, system.plan, system.timing
    parameters = zip(paths(plant.Parameters), flatten(system.parameters), strict=True)
    return {
        "format": PLANT_FORMAT,
        "version": PLANT_VERSION,
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
        **({"observer": plan.observer_title} if plan.observer else {}),
    }


def stated(value: float, unit: str) -> Row:
    """Return a number with its unit, which may be any."""
    return {"value": value, "unit": code_or_note(unit)}


def _finite(values: Row) -> Row:
    """Return the finite values; no limit is not written."""
    return {
        key: value for key, value in values.items() if value is not None and value not in (float("inf"), -float("inf"))
    }


def document_at(document: Row, point: str, values: Mapping[str, float]) -> Row:
    """Return the content of gains.json for another point, without measured values."""
    gains = {address: {**entry, "value": values[address]} for address, entry in document["gains"].items()}
    left = {key: part for key, part in document.items() if key not in ("objectives", "margins", "exports")}
    named = {"point": point} if "point" in left else {"study": {**left.get("study", {}), "point": point}}
    return {**left, "gains": gains, **named}
