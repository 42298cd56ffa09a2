"""The airframe inside gains.json: every number of the vehicle, and what turns its torques into motor commands.

    numbers     mass, inertia {x, y, z}, ... as in the airframe's file, lengths apart
    actuation   see `plant.quadrotor.airframes.actuation`; rotors: where they sit, which way they turn seen from above
    sha256      over the canonical form of {"numbers", "rotors"}; allow_unphysical: true where `broken_rules` are broken

The flying vehicle is `numbers` and the rotors; the rest of `actuation` follows from them.
"""

from collections.abc import Iterator
from math import isclose
from pathlib import Path
from typing import NamedTuple

import numpy as np

from plant.errors import InputError
from plant.quadrotor.airframes import Airframe
from plant.quadrotor.airframes.actuation import Actuation, actuation
from plant.quadrotor.airframes.geometry import FRAMES
from plant.quadrotor.airframes.rules import broken_rules
from plant.quadrotor.airframes.schema import GROUPS, OPTIONAL, SCALARS, NumberField, Sourced
from plant.quadrotor.nominal import mixer_matrix
from plant.quadrotor.vehicle import Vehicle
from plant.texts import LONGEST_TITLE, NAME
from plant.vectors import Rotors, Vec3
from tuner.gains.hashing import canonical_hash
from tuner.gains.quantities import plain, quantities, ucum
from tuner.gains.sections import DIGEST, Row, add_units, closed, listed, measured

# A reaction torque about +z, up, is that of a propeller that turns clockwise seen from above.
SPINS = {"clockwise": 1.0, "counterclockwise": -1.0}
CURVE = "T = thrust_max (f u^2 + (1 - f) u), u from 0 to 1"
# Derived numbers are as their digits say.
AGREEMENT = 1e-9
# Sizes of a number of an airframe in SI units: beyond them a digit slipped, and arithmetic overflows.
SMALLEST, LARGEST = 1e-15, 1e9
# Of the mixer: 17 for an Iris, 168 for a Crazyflie.
MAX_CONDITION = 1e12


_BOUNDS: dict[str, dict[str, float]] = {
    "positive": {"exclusiveMinimum": 0},
    "not negative": {"minimum": 0},
    "any": {},
    "above -1 and at most 1": {"exclusiveMinimum": -1, "maximum": 1},
}


def _number(field: NumberField) -> Row:
    return measured(ucum(field.unit), **_BOUNDS[field.sign])


NUMBERS = closed(
    {
        **{key: _number(field) for key, field in (SCALARS | OPTIONAL).items()},
        **{key: closed(dict.fromkeys("xyz", _number(field))) for key, field in GROUPS.items()},
    },
    optional=OPTIONAL,
)
ROTOR = closed(
    {
        "position": closed(dict.fromkeys("xy", measured("m"))),
        "spin": {"enum": list(SPINS)},
        "torque_ratio": measured("m", exclusiveMinimum=0),
    }
)
ACTUATION = closed(
    {
        **dict.fromkeys(("thrust_max", "thrust_min", "hover_thrust"), measured("N", minimum=0)),
        "hover_command": measured("1", minimum=0),
        "thrust_curve": closed({"model": {"const": CURVE}, "factor": measured("1", minimum=0, maximum=2)}),
        "lag": measured("s", exclusiveMinimum=0),
        "rotors": {**listed(ROTOR), "minItems": 4, "maxItems": 4},
    }
)
AIRFRAME = closed(
    {
        "name": {"type": "string", "pattern": f"^{NAME}(?!\n)$", "maxLength": 64},
        "title": {"type": "string", "minLength": 1, "maxLength": LONGEST_TITLE},
        "frame": {"enum": list(FRAMES)},
        "allow_unphysical": {"type": "boolean"},
        "sha256": DIGEST,
        "numbers": NUMBERS,
        "actuation": ACTUATION,
    },
    optional=("allow_unphysical", "sha256"),
)
"""The JSON Schema of the block."""


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
    """Return the numbers of a vehicle without rotors, optional ones if nonzero."""
    numbers: Row = {key: getattr(vehicle, key) for key in SCALARS}
    numbers |= {key: getattr(vehicle, key) or None for key in OPTIONAL}
    return add_units(NUMBERS, numbers | {key: getattr(vehicle, key)._asdict() for key in GROUPS})


def actuation_block(actuators: Actuation) -> Row:
    """Return the actuation of a vehicle."""
    turns = {sign: name for name, sign in SPINS.items()}
    rotors = [
        {"position": {"x": mount.x, "y": mount.y}, "spin": turns[mount.spin], "torque_ratio": mount.torque_ratio}
        for mount in actuators.rotors
    ]
    curve = {"model": CURVE, "factor": actuators.curve}
    derived = {"hover_command": actuators.hover_command, "thrust_curve": curve, "rotors": rotors}
    return add_units(ACTUATION, vars(actuators) | derived)


class AirframePart(NamedTuple):
    """A block that the schema accepts."""

    name: str
    title: str
    frame: str
    numbers: Row
    actuation: Row
    allow_unphysical: bool = False
    sha256: str | None = None

    @property
    def rotors(self) -> list[Row]:
        """Rotors in our order."""
        return self.actuation["rotors"]

    @property
    def vehicle(self) -> Vehicle:
        """The vehicle that flies."""
        rotors, numbers = plain(self.rotors), plain(self.numbers)
        fields: Row = {key: Vec3(**number) if key in GROUPS else number for key, number in numbers.items()}
        fields |= {f"rotor_{axis}": Rotors(*[rotor["position"][axis] for rotor in rotors]) for axis in "xy"}
        return Vehicle(**fields, spin=Rotors(*[SPINS[rotor["spin"]] for rotor in rotors]))

    @property
    def digest(self) -> str:
        """Hash of what flies."""
        return canonical_hash({"numbers": self.numbers, "rotors": self.rotors})


def airframe_of(block: Row, path: Path) -> Airframe:
    """Return the airframe of a block that the schema accepts; path: the file that it stands in."""
    part = AirframePart(**block)
    fields = {**SCALARS, **OPTIONAL, **{f"{key}.{axis}": field for key, field in GROUPS.items() for axis in "xyz"}}
    given = dict(quantities(part.numbers))
    sources = {
        key: Sourced(float(given[key]), field.unit, f"recorded in {path.name}")
        for key, field in fields.items()
        if key in given
    }
    return Airframe(part.name, part.title, part.frame, part.vehicle, sources, path)


def airframe_problems(block: Row) -> Iterator[InputError]:
    """Yield the errors of a block that satisfies the schema.

    Keys are inside the block.
    """
    part = AirframePart(**block)
    yield from list(_disproportionate(part)) or list(_unphysical(part)) or list(_derived_problems(part))
    if part.sha256 not in (None, part.digest):
        message = (
            "numbers and rotors have another hash: edited by hand? To accept the edit, remove airframe.sha256, too"
        )
        yield InputError(message, key="sha256")


def _disproportionate(part: AirframePart) -> Iterator[InputError]:
    for key, value in (*quantities(part.numbers, "numbers"), *quantities(part.actuation, "actuation")):
        if value != 0.0 and not SMALLEST <= abs(value) <= LARGEST:
            message = f"given {value:g}; allowed: 0, or a size from {SMALLEST:g} to {LARGEST:g}"
            yield InputError(message, key=f"{key}.value")


def _unphysical(part: AirframePart) -> Iterator[InputError]:
    if np.linalg.cond(mixer_matrix(part.vehicle)) > MAX_CONDITION:
        message = (
            "rotors at these places with these turns make no independent roll, pitch and yaw torques; correct them"
        )
        yield InputError(message, key="actuation.rotors")
    if (broken := broken_rules(part.vehicle)) and not part.allow_unphysical:
        remedy = 'correct the numbers, or write "allow_unphysical": true in airframe'
        yield InputError(f"no real airframe has these numbers: {'; '.join(broken)}; {remedy}", key="numbers")


def _derived_problems(part: AirframePart) -> Iterator[InputError]:
    given = dict(quantities(part.actuation))
    for key, derived in quantities(actuation_block(actuation(part.vehicle, given["thrust_curve.factor"]))):
        if not isclose(derived, given[key], rel_tol=AGREEMENT):
            message = f"given {given[key]:g}; from the airframe's numbers follows {derived:.12g}: correct either"
            yield InputError(message, key=f"actuation.{key}.value")
