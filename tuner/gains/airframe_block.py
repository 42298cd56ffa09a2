"""The airframe inside gains.json: every number of the vehicle, and what turns its torques into motor commands.

    numbers     mass, inertia {x, y, z}, ... as in the airframe's file, lengths apart
    actuation   see `plant.airframes.actuation`; rotors: where they sit, which way they turn seen from above
    sha256      over the canonical form of {"numbers", "rotors"}; allow_unphysical: true where `broken_rules` are broken

What flies is `numbers` and the rotors; the rest of `actuation` follows from them.
"""

from collections.abc import Iterator
from math import isclose
from pathlib import Path
from typing import Any

import numpy as np

from plant.airframes import Airframe
from plant.airframes.actuation import Actuation, actuation
from plant.airframes.geometry import FRAMES
from plant.airframes.rules import broken_rules
from plant.airframes.schema import GROUPS, SCALARS, Sourced
from plant.errors import InputError
from plant.nominal import mixer_matrix
from plant.texts import LONGEST_TITLE, NAME
from plant.vectors import Rotors, Vec3
from plant.vehicle import Vehicle
from tuner.gains.hashing import canonical_hash
from tuner.gains.sections import DIGEST, Row, closed, measured
from tuner.gains.ucum import quantity, ucum

# A reaction torque about +z, up, is that of a propeller that turns clockwise seen from above.
SPINS = {"clockwise": 1.0, "counterclockwise": -1.0}
CURVE = "T = thrust_max (f u^2 + (1 - f) u), u from 0 to 1"
# Derived numbers are as their digits say.
AGREEMENT = 1e-9
# Sizes of a number of an airframe in SI units: beyond them a digit slipped, and arithmetic overflows.
SMALLEST, LARGEST = 1e-15, 1e9
# Of the mixer: 17 for an Iris, 168 for a Crazyflie.
MOST_CONDITION = 1e12


def airframe_block(airframe: Airframe) -> Row:
    """Return the airframe as gains.json holds it."""
    numbers = numbers_block(airframe.vehicle)
    actuators = actuation_block(actuation(airframe.vehicle))
    physical: Row = {"allow_unphysical": True} if broken_rules(airframe.vehicle) else {}
    return {
        "name": airframe.name,
        "title": airframe.title,
        "frame": airframe.frame,
        **physical,
        "sha256": canonical_hash({"numbers": numbers, "rotors": actuators["rotors"]}),
        "numbers": numbers,
        "actuation": actuators,
    }


def numbers_block(vehicle: Vehicle) -> Row:
    """Return the numbers of a vehicle without its rotors."""
    scalars = {key: quantity(getattr(vehicle, key), field.unit) for key, field in SCALARS.items()}
    vectors = {
        key: {axis: quantity(value, field.unit) for axis, value in getattr(vehicle, key)._asdict().items()}
        for key, field in GROUPS.items()
    }
    return {**scalars, **vectors}


def actuation_block(actuators: Actuation) -> Row:
    """Return the actuation of a vehicle."""
    turns = {sign: name for name, sign in SPINS.items()}
    return {
        "thrust_max": quantity(actuators.thrust_max, "N"),
        "thrust_min": quantity(actuators.thrust_min, "N"),
        "hover_thrust": quantity(actuators.hover_thrust, "N"),
        "hover_command": quantity(actuators.hover_command, "1"),
        "thrust_curve": {"model": CURVE, "factor": quantity(actuators.curve, "1")},
        "lag": quantity(actuators.lag, "s"),
        "rotors": [
            {
                "position": {"x": quantity(mount.x, "m"), "y": quantity(mount.y, "m")},
                "spin": turns[mount.spin],
                "torque_ratio": quantity(mount.torque_ratio, "m"),
            }
            for mount in actuators.rotors
        ],
    }


def vehicle_of(block: Row) -> Vehicle:
    """Return the vehicle of a block that the schema accepts."""
    numbers, rotors = block["numbers"], block["actuation"]["rotors"]
    fields: Row = {key: float(numbers[key]["value"]) for key in SCALARS}
    fields |= {key: Vec3(*[float(numbers[key][axis]["value"]) for axis in "xyz"]) for key in GROUPS}
    fields |= {f"rotor_{axis}": Rotors(*[float(rotor["position"][axis]["value"]) for rotor in rotors]) for axis in "xy"}
    return Vehicle(**fields, spin=Rotors(*[SPINS[rotor["spin"]] for rotor in rotors]))


def airframe_of(block: Row, path: Path) -> Airframe:
    """Return the airframe of a block that the schema accepts; path: the file that it stands in."""
    numbers = {**SCALARS, **{f"{key}.{axis}": field for key, field in GROUPS.items() for axis in "xyz"}}
    sources = {
        key: Sourced(_value_at(block["numbers"], key), field.unit, f"recorded in {path.name}")
        for key, field in numbers.items()
    }
    return Airframe(block["name"], block["title"], block["frame"], vehicle_of(block), sources, path)


def airframe_problems(block: Row) -> Iterator[InputError]:
    """Yield what is wrong with a block that the schema accepts, keys inside the block."""
    wrong = list(_disproportionate(block)) or list(_unphysical(block)) or list(_derived_problems(block))
    yield from wrong
    rotors = block["actuation"]["rotors"]
    if "sha256" in block and block["sha256"] != canonical_hash({"numbers": block["numbers"], "rotors": rotors}):
        message = (
            "numbers and rotors have another hash: edited by hand? To accept the edit, remove airframe.sha256, too"
        )
        yield InputError(message, key="sha256")


def _disproportionate(block: Row) -> Iterator[InputError]:
    for section in ("numbers", "actuation"):
        for key, value in _numbers(block[section], section):
            if value != 0.0 and not SMALLEST <= abs(value) <= LARGEST:
                message = f"given {value:g}; allowed: 0, or a size from {SMALLEST:g} to {LARGEST:g}"
                yield InputError(message, key=f"{key}.value")


def _unphysical(block: Row) -> Iterator[InputError]:
    vehicle = vehicle_of(block)
    if np.linalg.cond(mixer_matrix(vehicle)) > MOST_CONDITION:
        message = (
            "rotors at these places with these turns make no independent roll, pitch and yaw torques; correct them"
        )
        yield InputError(message, key="actuation.rotors")
    if (broken := broken_rules(vehicle)) and not block.get("allow_unphysical", False):
        remedy = 'correct the numbers, or write "allow_unphysical": true in airframe'
        yield InputError(f"no real airframe has these numbers: {'; '.join(broken)}; {remedy}", key="numbers")


def _derived_problems(block: Row) -> Iterator[InputError]:
    factor = block["actuation"]["thrust_curve"]["factor"]["value"]
    for key, here in _numbers(actuation_block(actuation(vehicle_of(block), factor)), ""):
        there = _value_at(block["actuation"], key)
        if not isclose(here, there, rel_tol=AGREEMENT):
            message = f"given {there:g}; from the airframe's numbers follows {here:.12g}: correct either"
            yield InputError(message, key=f"actuation.{key}.value")


def _numbers(value: Any, key: str) -> Iterator[tuple[str, float]]:
    """Yield dotted key and value of every quantity in a block."""
    if isinstance(value, dict) and "value" in value:
        yield key, value["value"]
    elif isinstance(value, dict):
        for name, inner in value.items():
            yield from _numbers(inner, f"{key}.{name}" if key else name)
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from _numbers(inner, f"{key}[{i}]")


def _value_at(block: Any, key: str) -> float:
    for part in key.replace("[", ".").replace("]", "").split("."):
        block = block[int(part)] if isinstance(block, list) else block[part]
    return float(block["value"])


def airframe_schema() -> Row:
    """Return the JSON Schema of the block."""
    bounds: dict[str, Row] = {"positive": {"exclusiveMinimum": 0}, "not negative": {"minimum": 0}, "any": {}}
    scalars = {key: measured(ucum(field.unit), **bounds[field.sign]) for key, field in SCALARS.items()}
    vectors = {
        key: closed({axis: measured(ucum(field.unit), **bounds[field.sign]) for axis in "xyz"})
        for key, field in GROUPS.items()
    }
    rotor = closed(
        {
            "position": closed({axis: measured("m") for axis in "xy"}),
            "spin": {"enum": list(SPINS)},
            "torque_ratio": measured("m", exclusiveMinimum=0),
        }
    )
    actuators = {
        **{key: measured("N", minimum=0) for key in ("thrust_max", "thrust_min", "hover_thrust")},
        "hover_command": measured("1", minimum=0),
        "thrust_curve": closed({"model": {"const": CURVE}, "factor": measured("1", minimum=0, maximum=1)}),
        "lag": measured("s", exclusiveMinimum=0),
        "rotors": {"type": "array", "items": rotor, "minItems": 4, "maxItems": 4},
    }
    return closed(
        {
            "name": {"type": "string", "pattern": f"^{NAME}(?!\n)$", "maxLength": 64},
            "title": {"type": "string", "minLength": 1, "maxLength": LONGEST_TITLE},
            "frame": {"enum": list(FRAMES)},
            "allow_unphysical": {"type": "boolean"},
            "sha256": DIGEST,
            "numbers": closed({**scalars, **vectors}),
            "actuation": closed(actuators),
        },
        optional=("allow_unphysical", "sha256"),
    )
