"""Facts on a vehicle in command lines of Betaflight: hover throttle of its autopilot, dynamic notch, cells of the battery.

The hover throttle is a pulse [us]. src/main/flight/mixer.c maps 1050 to 2000 us onto the motor range from the idle of 5.5 % to
full, so the motor command is (pulse - 1000) / 1000 within 0.01. Nothing else in its files measures the vehicle.
"""

from collections.abc import Callable, Mapping
from math import inf

from plant.quadrotor.vehicle import Vehicle
from tuner.extensions.autopilots.vehicle_facts import (
    HOVER,
    MIN_COMMAND,
    SHARES,
    SPEED,
    Range,
    VehicleFact,
    cell_facts,
    exactly,
    given_number,
    hover_command,
    hover_frequency,
)

Values = Mapping[str, str | float]
HOVER_PARAMETERS = ("ap_hover_throttle", "autopilot_hover_throttle", "gps_rescue_throttle_hover")
"""Names of the hover throttle, the newest first."""
DEFAULT_PULSE, PULSE_ZERO, PULSE_RANGE = 1275.0, 1000.0, 1000.0
NOTCH_RANGE = (20.0, 1000.0)
"""Frequencies of a dynamic notch that are read [Hz]."""


def betaflight_facts(values: Values) -> list[VehicleFact]:
    """Return the facts of a file's settings."""
    return [*_hover_facts(values), *_notch_facts(values), *cell_facts(values, "force_battery_cell_count")]


def _hover_facts(values: Values) -> list[VehicleFact]:
    for name in HOVER_PARAMETERS:
        pulse = given_number(values, name, DEFAULT_PULSE)
        command = 0.0 if pulse is None else (pulse - PULSE_ZERO) / PULSE_RANGE
        if MIN_COMMAND <= command <= 1.0:
            expression = f"({name} - {PULSE_ZERO:g}) / {PULSE_RANGE:g}"
            return [VehicleFact(HOVER, expression, command, exactly(hover_command), SHARES)]
    return []


def _notch_facts(values: Values) -> list[VehicleFact]:
    """Return the ends of a dynamic notch around the rotors' speed."""
    if given_number(values, "dyn_notch_count", inf) == 0.0:
        return []
    ends: dict[str, Callable[[Vehicle], Range]] = {
        "dyn_notch_min_hz": lambda vehicle: (0.0, hover_frequency(vehicle)),
        "dyn_notch_max_hz": lambda vehicle: (hover_frequency(vehicle), inf),
    }
    low, high = NOTCH_RANGE
    given = {name: given_number(values, name, inf) for name in ends}
    return [
        VehicleFact(SPEED, name, frequency, ends[name], is_exact=False)
        for name, frequency in given.items()
        if frequency is not None and low <= frequency <= high
    ]
