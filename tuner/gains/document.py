"""From a controller to the content of gains.json."""

from collections.abc import Mapping
from dataclasses import asdict
from math import nan

from objectives.margins.steady_state import SteadyState
from plant.gains import gain_addresses
from plant.laws.law import Law
from plant.nominal import BATTERY_RANGES, NOTCH_RANGES
from tuner.gains.airframe_block import airframe_block
from tuner.gains.controller import Controller, VehicleRecord
from tuner.gains.hashing import content_hash
from tuner.gains.quantities import quantity
from tuner.gains.sections import CONVENTIONS, FORMAT, MOST_EXACT, STRUCTURE, VERSION, Row
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
        "generator": {"name": "holdfast", "version": version()},
        "conventions": CONVENTIONS,
        "airframe": airframe_block(controller.airframe),
        "controller": controller_block(controller),
        "gains": gains_block(controller, ranges),
        **({} if controller.vehicle is None else {"vehicle": vehicle_block(controller.vehicle)}),
        **({"states": [state_block(state) for state in controller.states]} if controller.states else {}),
        **provenance,
    }
    return {**document, "sha256": content_hash(document)}


def controller_block(controller: Controller) -> Row:
    """Return laws, periods, options, structure and how the laws are sampled."""
    options = asdict(controller.options)
    tilt, cutoff = options.pop("tilt_limit"), options.pop("yaw_torque_cutoff")
    notches = notches_block(*[options.pop(name) for name in NOTCH_RANGES])
    battery = battery_block(*[options.pop(name) for name in BATTERY_RANGES])
    laws = {"position": controller.cascade.position, "attitude": controller.cascade.attitude}
    return {
        **{loop: law.name for loop, law in laws.items()},
        "control_period": quantity(controller.control_period, "s"),
        "plant_step": quantity(controller.plant_step, "s"),
        "tilt_limit": quantity(tilt, "rad"),
        **({"yaw_torque_cutoff": quantity(cutoff, "Hz")} if cutoff else {}),
        **notches,
        **battery,
        **options,
        **({} if controller.cascade.position_every == 1 else {"position_every": controller.cascade.position_every}),
        "structure": STRUCTURE,
        "discretisation": {loop: law.discretisation for loop, law in laws.items()},
        **({"code": code} if (code := code_block(laws)) else {}),
    }


def notches_block(harmonics: int, quality: float, least: float) -> Row:
    """Return the notches that follow the rotors, nothing where there are none."""
    if not harmonics:
        return {}
    numbers = (harmonics, quantity(quality, "1"), quantity(least, "Hz"))
    return dict(zip(NOTCH_RANGES, numbers, strict=True))


def battery_block(compensation: float, cutoff: float) -> Row:
    """Return the compensation of a battery's sag, nothing where there is none."""
    numbers = (quantity(compensation, "1"), quantity(cutoff, "Hz"))
    return dict(zip(BATTERY_RANGES, numbers, strict=True)) if compensation else {}


def code_block(laws: Mapping[str, Law]) -> Row:
    """Return file and digest of the laws that are not bundled, by loop."""
    return {
        loop: {"file": law.origin.short, "digest": law.origin.digest}
        for loop, law in laws.items()
        if law.origin is not None
    }


def vehicle_block(vehicle: VehicleRecord) -> Row:
    """Return what is recorded of the vehicle that gains were imported from."""
    return {
        **asdict(vehicle),
        "settings": [{"name": name, "value": value} for name, value in vehicle.settings.items()],
        "parameters": [{"name": name, "value": value} for name, value in vehicle.parameters.items()],
        "kept": list(vehicle.kept),
    }


def state_block(state: SteadyState) -> Row:
    """Return a steady state: heading, velocity over ground and wind."""
    vectors = {"velocity": state.velocity, "wind": state.wind}
    rows = {name: [quantity(part, "m/s") for part in vector] for name, vector in vectors.items()}
    return {"name": state.name, "yaw": quantity(state.yaw, "rad"), **rows}


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
    """Return whether a gain lies in a range, to the rounding of a search that works in its logarithm."""
    return low - ROUNDING * abs(low) <= value <= high + ROUNDING * abs(high)


def _range(ranges: Ranges, address: str, value: float) -> Row:
    """Return the range that a search had for a gain; a default that lies outside was not found in it."""
    low, high = ranges.get(address, (nan, nan))
    return {"low": low, "high": high} if within(value, low, high) else {}


def seed_entry(seed: int) -> int | str:
    """Return a seed as JSON holds it: as text where a double would not tell it from its neighbours."""
    return seed if seed <= MOST_EXACT else str(seed)
