"""Facts on a vehicle in its parameter file, next to its airframe.

A fact is a value that somebody measured or typed for this vehicle: a hover command, rotor positions, a notch at the rotors'
frequency. A value that equals the default of the firmware is none, because it was in the file before the vehicle was.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import hypot, inf, isfinite, pi, sqrt

from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.airframes.rules import hover_speed
from plant.quadrotor.vehicle import Vehicle
from tuner.extensions.autopilots.parameters import single
from tuner.extensions.autopilots.scales import hover_share

Range = tuple[float, float]
"""Lowest and highest value of a parameter that fits a vehicle."""
SHARES: Range = (0.0, 1.0)
"""Range of a share of the full command."""
CELL_VOLTAGE = 4.2
"""Voltage of a full lithium cell [V]."""
MAX_CELLS = 24
"""Largest number of cells in series that is read."""
MIN_COMMAND = 0.02
"""Smallest hover command that is read; a vehicle would lift 2,500 times its weight with the square of it."""
NUMBER = re.compile(r"\s*[+-]?(\d{1,9}\.?\d{0,9}|\.\d{1,9})\s*")


@dataclass(frozen=True)
class Quantity:
    """A number of vehicles that parameter files hold.

    Attributes:
        name: Name in sentences.
        unit: Unit with a blank before it, "" without any.
        phrase: Verb of a sentence whose subject is an airframe and whose object is the number.
        tolerance: Standard deviation of the number's logarithm between a vehicle and its own file.
    """

    name: str
    unit: str
    phrase: str
    tolerance: float


# Payload, charge and the air of the day change a hover command by some 10 %, and a rotor speed by half of that.
HOVER = Quantity("hover command", "", "hovers at", 0.1)
SPEED = Quantity("rotor speed in hover", " Hz", "turns its rotors in hover at", 0.05)
ARM = Quantity("arm", " m", "has an arm of", 0.02)
WIDTH = Quantity(
    "width over length of the rotor positions", "", "has a width over length of its rotor positions of", 0.02
)
VOLTAGE = Quantity("voltage of the full battery", " V", "has a full battery of", 0.05)


@dataclass(frozen=True)
class VehicleFact:
    """A fact of a parameter file.

    Attributes:
        quantity: The number.
        parameter: Parameter that holds it, or its expression in parameters.
        value: Its value in the unit of the quantity.
        fitting: Return the values that fit a vehicle, None for one that lacks the number.
        bounds: Range that the firmware holds the value to.
        is_exact: False for a limit that a number lies above or below, which narrows no vehicles.
    """

    quantity: Quantity
    parameter: str
    value: float
    fitting: Callable[[Vehicle], Range | None]
    bounds: Range = (0.0, inf)
    is_exact: bool = True

    @property
    def text(self) -> str:
        """Parameter and value in words."""
        return f"{self.parameter} = {self.value:.3g}{self.quantity.unit}"


def given_number(values: Mapping[str, str | float], name: str, default: float) -> float | None:
    """Return the number of a parameter; None where it is missing, no number, or the default of the firmware."""
    given = values.get(name)
    if isinstance(given, str):
        given = float(given) if NUMBER.fullmatch(given) else None
    if given is None or not isfinite(given) or single(given) == single(default):
        return None
    return given


def hover_command(vehicle: Vehicle) -> float:
    """Return the motor command at hover [1], in 0 to 1."""
    return actuation(vehicle).hover_command


def linearized_hover(vehicle: Vehicle, model: float) -> float:
    """Return the hover command [1] before a thrust curve that the autopilot undoes; model: its factor."""
    return max(hover_share(actuation(vehicle), model), MIN_COMMAND)


def hover_frequency(vehicle: Vehicle) -> float:
    """Return the rotor speed at hover [Hz]."""
    return hover_speed(vehicle) / (2.0 * pi)


def rotor_arm(x: Sequence[float], y: Sequence[float]) -> float:
    """Return the root mean square distance of rotors from their middle [m]; x, y: their positions [m]."""
    return hypot(_half_length(x), _half_length(y))


def rotor_width(x: Sequence[float], y: Sequence[float]) -> float:
    """Return the width over length of rotor positions [1]; x: forward [m], y: to a side [m]."""
    return _half_length(y) / _half_length(x)


def battery_fact(parameter: str, voltage: float) -> VehicleFact:
    """Return the fact of a full battery's voltage [V]."""
    return VehicleFact(VOLTAGE, parameter, voltage, _battery)


def cell_facts(values: Mapping[str, str | float], parameter: str) -> list[VehicleFact]:
    """Return the fact of a number of cells; 0 lets the firmware count them."""
    cells = given_number(values, parameter, 0.0)
    if cells is None or not 1.0 <= cells <= MAX_CELLS:
        return []
    return [battery_fact(f"{CELL_VOLTAGE:g} V times {parameter}", CELL_VOLTAGE * cells)]


def exactly(number: Callable[[Vehicle], float]) -> Callable[[Vehicle], Range]:
    """Return the fitting values of a number that has one value."""

    def fitting(vehicle: Vehicle) -> Range:
        value = number(vehicle)
        return value, value

    return fitting


def _battery(vehicle: Vehicle) -> Range | None:
    full = vehicle.battery_full
    return (full, full) if full > 0.0 else None


def _half_length(places: Sequence[float]) -> float:
    """Return the root mean square distance of places from their mean."""
    middle = sum(places) / len(places)
    return sqrt(sum((place - middle) ** 2 for place in places) / len(places))
