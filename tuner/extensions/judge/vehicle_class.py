"""Default airframe of each firmware, used when none is given: a middle vehicle with the ranges of a parts list."""

from dataclasses import dataclass, replace
from math import exp

from plant.quadrotor.airframes import Airframe, load
from plant.quadrotor.airframes.uncertainty import Uncertainty
from tuner.extensions.parts_list.estimate import QUANTILE, uncertainty


@dataclass(frozen=True)
class VehicleClass:
    """Vehicles that usually fly a firmware.

    Attributes:
        noun: Description of the vehicles.
        airframe: The bundled one in their middle.
        mass: Standard deviation of the logarithm of their mass.
    """

    noun: str
    airframe: str
    mass: float


CLASSES = {
    "betaflight": VehicleClass("a 5 inch racer", "racer5", 0.2),
    "px4": VehicleClass("a quadrotor of 450 mm", "f450", 0.2),
    "ardupilot": VehicleClass("a quadrotor of 450 mm", "f450", 0.2),
    "crazyflie": VehicleClass("a Crazyflie 2.x", "crazyflie-pybullet", 0.1),
}
"""Class of each firmware."""
SHOWN = {"mass": "mass", "inertia.x": "Ixx", "thrust_coefficient": "thrust coefficient", "lag_up": "rotor lag"}
"""Numbers of an airframe whose ranges are shown, in words."""


def class_airframe(source: str) -> Airframe:
    """Return the middle of a firmware's class with wide ranges."""
    chosen = CLASSES[source]
    ranges = uncertainty(hover=False)
    deviations = [
        chosen.mass if name == "mass" else value for name, value in zip(ranges.names, ranges.deviations, strict=True)
    ]
    wide = Uncertainty(ranges.names, tuple(deviations), ranges.correlation)
    return replace(load(chosen.airframe), uncertainty=wide, title=f"class of {chosen.noun}")


def ranges_text(airframe: Airframe) -> str:
    """Return the main 95 % ranges of an airframe's uncertainty in words."""
    ranges = airframe.uncertainty
    if ranges is None:
        return "mass and inertia +-10 %, thrust +-5 %, rotor lag +-20 %"
    parts = []
    for name, deviation in zip(ranges.names, ranges.deviations, strict=True):
        if name in SHOWN:
            factor, number = exp(QUANTILE * deviation), airframe.sources[name]
            parts.append(f"{SHOWN[name]} {number.value / factor:.2g} to {number.value * factor:.2g} {number.unit}")
    return ", ".join(parts)
