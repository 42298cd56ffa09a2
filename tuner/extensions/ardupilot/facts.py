"""Facts on a vehicle in parameter files of ArduPilot: hover throttle, notch at the rotors, full battery.

ArduPilot learns MOT_THST_HOVER in flight with a filter of 10 s, so a value of exactly 0.35, its default, is not learned.
AP_MotorsMulticopter.cpp: the throttle goes through the inverse of the thrust curve MOT_THST_EXPO, then onto the range
from MOT_SPIN_MIN to MOT_SPIN_MAX of the motor command. Airframes from logs or benches may count their command either way.
"""

from collections.abc import Mapping

from plant.quadrotor.vehicle import Vehicle
from tuner.extensions.ardupilot.ranges import EXPO
from tuner.extensions.autopilots.vehicle_facts import (
    HOVER,
    MIN_COMMAND,
    SPEED,
    Range,
    VehicleFact,
    battery_fact,
    exactly,
    given_number,
    hover_command,
    hover_frequency,
    linearized_hover,
)

Values = Mapping[str, str | float]
HOVER_PARAMETERS = {"MOT_THST_HOVER": (0.35, 1.0), "THR_MID": (500.0, 0.001)}
"""Parameter of the hover throttle, the latter before Copter 3.4 -> its default, and its unit [1]."""
LEARNED_RANGE = (0.125, 0.6875)
"""Range that the firmware holds its hover throttle to."""
DEFAULT_EXPO, DEFAULT_SPIN_MIN, DEFAULT_SPIN_MAX = 0.65, 0.15, 0.95
THROTTLE_MODE = 1.0
"""Value of INS_HNTCH_MODE for a notch whose frequency follows the throttle."""
NOTCH_RANGE = (5.0, 2000.0)
"""Frequencies of a notch that are read [Hz]."""
BATTERY_RANGE = (2.0, 110.0)
"""Voltages of a full battery that are read [V]."""


def ardupilot_facts(values: Values) -> list[VehicleFact]:
    """Return the facts of a file's parameters."""
    return [*_hover_facts(values), *_notch_facts(values), *_battery_facts(values)]


def _hover(values: Values) -> tuple[str, float] | None:
    """Return parameter and value [1] of the hover throttle; None for a default."""
    for name, (default, unit) in HOVER_PARAMETERS.items():
        hover = given_number(values, name, default)
        if hover is not None and MIN_COMMAND <= unit * hover <= 1.0:
            return (name if unit == 1.0 else f"{unit:g} {name}"), unit * hover
    return None


def _hover_facts(values: Values) -> list[VehicleFact]:
    hover = _hover(values)
    if hover is None:
        return []
    expo = min(max(_number(values, EXPO, DEFAULT_EXPO), -1.0), 1.0)
    spin = _number(values, "MOT_SPIN_MIN", DEFAULT_SPIN_MIN), _number(values, "MOT_SPIN_MAX", DEFAULT_SPIN_MAX)
    return [VehicleFact(HOVER, *hover, lambda vehicle: throttle_range(vehicle, expo, spin), LEARNED_RANGE)]


def throttle_range(vehicle: Vehicle, expo: float, spin: Range) -> Range:
    """Return the hover throttles [1] with and without the motors' range.

    Args:
        vehicle: Vehicle that hovers.
        expo: Factor of the thrust curve.
        spin: Commands of least and of full thrust [1].
    """
    unranged = linearized_hover(vehicle, expo)
    low, high = spin
    if not 0.0 <= low < high <= 1.0:
        return unranged, unranged
    command = max((hover_command(vehicle) - low) / (high - low), MIN_COMMAND)
    ranged = max(expo * command**2 + (1.0 - expo) * command, MIN_COMMAND)
    return min(unranged, ranged), max(unranged, ranged)


def _notch_facts(values: Values) -> list[VehicleFact]:
    """Return the rotor speed of a notch that follows the throttle: INS_HNTCH_FREQ at the throttle INS_HNTCH_REF."""
    # A notch that follows measured speeds has its lowest frequency there.
    if _number(values, "INS_HNTCH_ENABLE", 0.0) != 1.0 or _number(values, "INS_HNTCH_MODE", 1.0) != THROTTLE_MODE:
        return []
    frequency, reference = given_number(values, "INS_HNTCH_FREQ", 80.0), _number(values, "INS_HNTCH_REF", 0.0)
    low, high = NOTCH_RANGE
    if frequency is None or not low <= frequency <= high or not MIN_COMMAND <= reference <= 1.0:
        return []
    hover = _hover(values)
    # The firmware scales by the root of the throttle, as thrust goes with the square of the speed.
    at_hover = frequency * ((reference if hover is None else hover[1]) / reference) ** 0.5
    return [VehicleFact(SPEED, "INS_HNTCH_FREQ at the hover throttle", at_hover, exactly(hover_frequency))]


def _battery_facts(values: Values) -> list[VehicleFact]:
    voltage, (low, high) = given_number(values, "MOT_BAT_VOLT_MAX", 0.0), BATTERY_RANGE
    if voltage is None or not low <= voltage <= high:
        return []
    return [battery_fact("MOT_BAT_VOLT_MAX", voltage)]


def _number(values: Values, name: str, default: float) -> float:
    """Return the number of a parameter, the default where it is missing."""
    given = given_number(values, name, default)
    return default if given is None else given
