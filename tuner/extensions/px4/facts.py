"""Facts on a vehicle in parameter files of PX4: hover command, rotor positions, cells of the battery.

The allocation of PX4 divides by its own scale, so a vehicle flies with rotor positions of any size. Positions of the generic
frames, 0.15 m (airframe 4001) and 1 m (its documentation), are placeholders. CA_ROTORi_KM is 0.05 in nearly all files, and so
no fact; THR_MDL_FAC belongs to the hover command, and the loops fly at IMU_GYRO_RATEMAX already.
"""

from collections.abc import Mapping, Sequence
from math import inf

from tuner.extensions.autopilots.vehicle_facts import (
    ARM,
    HOVER,
    MIN_COMMAND,
    SHARES,
    WIDTH,
    VehicleFact,
    cell_facts,
    exactly,
    given_number,
    linearized_hover,
    rotor_arm,
    rotor_width,
)
from tuner.extensions.px4.map import HOVER as HOVER_PARAMETER
from tuner.extensions.px4.map import MODEL, TABLE

Values = Mapping[str, str | float]
ROTORS = range(4)
PLACES = "CA_ROTORi_PX and CA_ROTORi_PY"
GENERIC_PLACES = (0.15, 1.0)
"""Coordinates of the rotors of generic frames [m]."""
MIN_LENGTH, MAX_LENGTH = 0.01, 10.0
PLACE_TOLERANCE = 1e-6


def px4_facts(values: Values) -> list[VehicleFact]:
    """Return the facts of a file's parameters."""
    return [*_hover_facts(values), *_place_facts(values), *cell_facts(values, "BAT1_N_CELLS")]


def _hover_facts(values: Values) -> list[VehicleFact]:
    hover = given_number(values, HOVER_PARAMETER, TABLE[HOVER_PARAMETER].usual)
    if hover is None or not MIN_COMMAND <= hover <= 1.0:
        return []
    model = min(max(given_number(values, MODEL, 0.0) or 0.0, 0.0), 1.0)
    return [
        VehicleFact(HOVER, HOVER_PARAMETER, hover, exactly(lambda vehicle: linearized_hover(vehicle, model)), SHARES)
    ]


def _place_facts(values: Values) -> list[VehicleFact]:
    """Return arm and width of the rotor positions, none of generic frames."""
    x, y = (_coordinates(values, axis) for axis in "XY")
    if not x or not y or _is_generic((*x, *y)):
        return []
    arm, width = rotor_arm(x, y), rotor_width(x, y)
    if not MIN_LENGTH <= arm <= MAX_LENGTH:
        return []
    return [
        VehicleFact(ARM, f"arm of {PLACES}", arm, exactly(lambda one: rotor_arm(one.rotor_x, one.rotor_y))),
        VehicleFact(
            WIDTH, f"width over length of {PLACES}", width, exactly(lambda one: rotor_width(one.rotor_x, one.rotor_y))
        ),
    ]


def _coordinates(values: Values, axis: str) -> list[float]:
    """Return a coordinate of each rotor [m]; none where the rotors are not four, or lie on a line."""
    if values.get("CA_ROTOR_COUNT", 4.0) != 4.0:
        return []
    places = [given_number(values, f"CA_ROTOR{rotor}_P{axis}", inf) for rotor in ROTORS]
    numbers = [place for place in places if place is not None and abs(place) <= MAX_LENGTH]
    is_whole = len(numbers) == len(places) and max(numbers) - min(numbers) >= MIN_LENGTH
    return numbers if is_whole else []


def _is_generic(coordinates: Sequence[float]) -> bool:
    """Return True for the coordinates of one generic frame, 0 among them."""
    return any(
        all(min(abs(place), abs(abs(place) - size)) <= PLACE_TOLERANCE for place in coordinates)
        for size in GENERIC_PLACES
    )
