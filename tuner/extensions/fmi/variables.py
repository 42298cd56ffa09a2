"""The variables of the FMU: inputs and outputs of a control step, and what is built into it, with units and meaning.

The value reference of a variable is its place in the list; inputs come first, then outputs, then constants.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from plant.quadrotor.gains import gain_addresses
from plant.quadrotor.nominal import nominal
from tuner.gains import Controller

BASE = ("kg", "m", "s", "rad")
DERIVED = {"N": {"kg": 1, "m": 1, "s": -2}, "Hz": {"s": -1}, "us": {"s": 1}, "%": {}, "1": {}}
SCALES = {"us": 1e-6, "%": 0.01}
"""Units that are a multiple of one of the base units or of 1, with the multiple; they stand alone."""
FACTOR = re.compile(r"(/?)\s*([A-Za-z]+|1|%)(?:\^(?:\((-?\d+(?:/\d+)?)\)|(-?\d+)))?\s*")


def exponents(unit: str) -> dict[str, Fraction] | None:
    """Return the nonzero exponents of kg, m, s, rad; of a unit like "rad/s", "N m" or "rad^(1/2) s^(-3/2)".

    None for a unit of others, such as those of a user's plant.
    """
    total: dict[str, Fraction] = {}
    place = 0
    while place < len(unit):
        matched = FACTOR.match(unit, place)
        if matched is None:
            return None
        slash, symbol, fraction, digits = matched.groups()
        power = Fraction(fraction or digits or 1) * (-1 if slash else 1)
        parts: Mapping[str, int] = DERIVED.get(symbol) if symbol in DERIVED else {symbol: 1}  # pyright: ignore
        for base, count in parts.items():
            if base not in BASE:
                return None
            total[base] = total.get(base, Fraction(0)) + power * count
        place = matched.end()
    return {base: power for base, power in total.items() if power}


def base_unit(unit: str) -> dict[str, float] | None:
    """Return exponents and factor, if any, by attributes of a BaseUnit.

    Exponents are integers; None for an unknown unit, and where one is a fraction, which FMI 2.0 and SSP cannot say.
    """
    matched = exponents(unit)
    if matched is None or any(power.denominator != 1 for power in matched.values()):
        return None
    factor = {"factor": SCALES[unit]} if unit in SCALES else {}
    return {base: int(matched[base]) for base in BASE if base in matched} | factor


VECTOR = ("x", "y", "z")
GAIN_PREFIX = "gains."


@dataclass(frozen=True)
class FmuVariable:
    """A variable of an FMU.

    Attributes:
        name: Name in the FMU.
        kind: "input", "output" or "constant".
        unit: Our unit, "1" without.
        start: Initial value.
        about: One sentence.
        member: Place in the C interface, e.g. "reference.position.x"; empty for constants.
    """

    name: str
    kind: str
    unit: str
    start: float
    about: str
    member: str = ""


def variables(controller: Controller) -> list[FmuVariable]:
    """Return all variables in the order of their value references."""
    return [*_inputs(), *_outputs(controller), *_constants(controller)]


def gain_variables(controller: Controller) -> list[FmuVariable]:
    """Return the gains alone, in column order."""
    return [
        FmuVariable(
            f"{GAIN_PREFIX}{gain.address}", "constant", gain.unit, controller.gains[gain.column], gain.info.meaning
        )
        for gain in gain_addresses(controller.cascade)
    ]


def _inputs() -> list[FmuVariable]:
    goal, seen = "reference", "measurement"
    return [
        *_vector(goal, "position", "m", "Position asked for, world ENU"),
        *_vector(goal, "velocity", "m/s", "Velocity asked for, world ENU"),
        *_vector(goal, "acceleration", "m/s^2", "Acceleration asked for, world ENU"),
        _input(goal, "roll", "rad", "Roll asked for where hold is 0"),
        _input(goal, "pitch", "rad", "Pitch asked for where hold is 0"),
        _input(goal, "yaw", "rad", "Yaw asked for"),
        _input(goal, "yaw_rate", "rad/s", "Rate of the yaw asked for"),
        _input(goal, "hold", "1", "1: x and y are tracked; 0: roll and pitch are", 1.0),
        *_vector(seen, "position", "m", "Measured position, world ENU"),
        *_vector(seen, "velocity", "m/s", "Measured velocity, world ENU"),
        *_vector(seen, "angles", "rad", "Measured roll (x), pitch (y), yaw (z) of ZYX Euler angles"),
        *_vector(seen, "rate", "rad/s", "Measured body rate, body FLU"),
        *_vector(seen, "thrust_direction", "1", "Body z axis in world ENU", (0.0, 0.0, 1.0)),
        *_vector(seen, "heading", "1", "(cos yaw, sin yaw, 0) of the measured yaw", (1.0, 0.0, 0.0)),
    ]


def _outputs(controller: Controller) -> list[FmuVariable]:
    vehicle = controller.airframe.vehicle
    hover = nominal(vehicle, controller.options, controller.control_period).hover
    places = ("front left", "front right", "rear left", "rear right")
    about = "Thrust of the rotor {} that the controller commands"
    return [
        *[
            FmuVariable(f"rotor_thrust[{i + 1}]", "output", "N", hover, about.format(place), f"rotor_thrust[{i}]")
            for i, place in enumerate(places)
        ],
        FmuVariable("thrust", "output", "N", 4.0 * hover, "Sum of the rotor thrusts", "thrust"),
        *[
            FmuVariable(
                f"torque.{axis}", "output", "N m", 0.0, "Torque of the rotor thrusts, body FLU", f"torque.{axis}"
            )
            for axis in VECTOR
        ],
    ]


def _constants(controller: Controller) -> list[FmuVariable]:
    period = FmuVariable("control_period", "constant", "s", controller.control_period, "Time between two control steps")
    return [period, *gain_variables(controller)]


def _input(record: str, name: str, unit: str, about: str, start: float = 0.0) -> FmuVariable:
    return FmuVariable(f"{record}.{name}", "input", unit, start, about, f"{record}.{name}")


def _vector(
    record: str, name: str, unit: str, about: str, start: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> list[FmuVariable]:
    return [_input(record, f"{name}.{axis}", unit, about, value) for axis, value in zip(VECTOR, start, strict=True)]
