"""An airframe without a log: from what stands on a parts list, with ranges as wide as the sources differ.

Thrust is G. Staples' fit to bench data of propellers ("Propeller static & dynamic thrust calculation", 2013): thrust over the
square of the speed goes with D^3.5 P^0.5, within 26 % for 95 % of them, slow-fly propellers up to 67 % above. Torque and the drag
of a climb follow from momentum theory (J. G. Leishman, Principles of Helicopter Aerodynamics, chapter 2). Inertias, lag and the
speed at full command have the spread of published airframes, those in `plant/quadrotor/airframes` among them.
"""

from math import pi, sqrt
from typing import NamedTuple

import numpy as np

from plant.errors import InputError
from plant.quadrotor.airframes.rules import THRUST_TO_WEIGHT
from plant.quadrotor.airframes.schema import Sourced
from plant.quadrotor.airframes.uncertainty import NAMES, Uncertainty
from tuner.analysis.airframe_text import rounded, uncertainty_from

GRAVITY, DENSITY, INCH = 9.81, 1.225, 0.0254
STATIC = 0.1313
"""Staples' static thrust as a coefficient: C_T = 0.1313 sqrt(P / D) in T = C_T rho n^2 D^4."""
BLADES = 0.8
"""Power of the number of blades that thrust goes with: less than 1, for blades fly in each other's wake."""
MERIT = 0.45
"""Figure of merit of small propellers at rest; published ones have 0.3 to 0.65."""
CELL_VOLTAGE = 3.7
"""Nominal voltage of a lithium cell [V]."""
LOAD_FACTOR = 0.7
"""Speed at full command over that without load: 0.45 to 0.95."""
GYRATION, SHARE = 0.26, 0.86
"""Ixx over mass times the squared distance to the motors: 0.15 where 30 % of the mass is at the motors and the rest in
the middle. Izz over Ixx + Iyy, 1 of a flat vehicle.
"""
LAG, LAG_AT = 0.03, 0.15
"""Time constant of a motor with its propeller [s] at a diameter [m]: of 0.13 to 0.25 m 0.0125 to 0.05, coreless ones up to 0.1.

Of others as times scale with length, as its root (Froude) up to in proportion (Mach): A. Kushleyev, D. Mellinger, C. Powers, V.
Kumar, "Towards a swarm of agile micro quadrotors", Autonomous Robots 35, 2013. Taken is the root.
"""
ROTOR = 0.13
"""Inertia of a rotor over D^5 [kg/m3], were all propellers of one shape and density; of bundled ones 0.11 to 0.17."""
CLIMB_DRAG = 0.4
"""Drag of a climb over weight / induced speed of hover."""
SIDE_DRAG = 0.2
"""Drag of sideways flight over weight / induced speed of hover."""
MAX_THRUST = 0.98 * THRUST_TO_WEIGHT[1]
"""Thrust to weight to which a higher estimate is lowered."""
MIN_THRUST = 1.3
"""Thrust to weight below which an estimate is refused."""

SPREADS: dict[str, dict[str, float]] = {
    "mass": {"weighed": 0.02},
    "arm": {"length": 0.02},
    "inertia.x": {"weighed": 0.02, "length": 0.04, "layout": 0.25, "layout x": 0.2},
    "inertia.y": {"weighed": 0.02, "length": 0.04, "layout": 0.25, "layout y": 0.2},
    "inertia.z": {"weighed": 0.02, "length": 0.04, "layout": 0.25, "layout x": 0.1, "layout y": 0.1, "flatness": 0.07},
    "thrust_coefficient": {"propeller": 0.35, "motor": 0.5},
    "torque_ratio": {"propeller": 0.175, "merit": 0.35},
    "lag_up": {"lag": 0.5, "up": 0.2},
    "lag_down": {"lag": 0.5, "down": 0.2},
    "drag_linear.z": {"climb": 1.0},
}
"""Number -> independent causes -> standard deviation of its logarithm from each; what numbers share makes their correlation."""
AT_HOVER = {"weighed": 0.02, "hover": 0.1}
"""The same of thrust_coefficient where the command at hover is known to 5 %."""
QUANTILE = 1.96
"""Quantile of a 95 % interval, in standard deviations."""


class Propeller(NamedTuple):
    """Diameter and pitch [m], number of blades."""

    diameter: float
    pitch: float
    blades: int = 2


class PartsList(NamedTuple):
    """Known data of a vehicle: mass [kg], wheelbase: from a motor to the one opposite [m], propeller, speed constant of the
    motors [rpm/V], cells of the battery, and the command at hover as a share of full command, None if unknown.
    """

    mass: float
    wheelbase: float
    propeller: Propeller
    kv: float
    cells: int
    hover: float | None = None


class Estimate(NamedTuple):
    """An estimated airframe.

    Attributes:
        values: Every number of an airframe file of frame "x".
        uncertainty: Uncertainty of these numbers.
        thrust_to_weight: At speed_max [1].
        thrust_of_parts: The same before speed_max was lowered [1].
    """

    values: dict[str, Sourced]
    uncertainty: Uncertainty
    thrust_to_weight: float
    thrust_of_parts: float

    @property
    def is_lowered(self) -> bool:
        """True where speed_max was lowered to what a file may hold."""
        return self.thrust_to_weight < self.thrust_of_parts

    def interval(self, name: str) -> tuple[float, float]:
        """Return the 95 % interval of a number of the uncertainty; of `arm` that of the length."""
        factor = float(np.exp(QUANTILE * self.uncertainty.deviations[self.uncertainty.names.index(name)]))
        value = self.values[name].value
        return value / factor, value * factor


def estimated(parts: PartsList) -> Estimate:
    """Return the airframe of a parts list; InputError where its propellers would not lift it."""
    coefficient = thrust_coefficient(parts.propeller)
    free = LOAD_FACTOR * parts.kv * CELL_VOLTAGE * parts.cells * 2.0 * pi / 60.0
    weight = parts.mass * GRAVITY
    ratio = 4.0 * coefficient * free**2 / weight if parts.hover is None else parts.hover**-2
    if ratio < MIN_THRUST:
        raise InputError(
            f"these parts would lift {ratio:.2g} times the weight, and at least {MIN_THRUST:g} is needed to fly; check the "
            "mass [kg], the propeller [inch], kv [rpm/V] and cells"
        )
    limited = min(ratio, MAX_THRUST)
    full = sqrt(limited * weight / (4.0 * coefficient))
    return Estimate(
        _values(parts, coefficient, full, lowered=limited < ratio), uncertainty(parts.hover is not None), limited, ratio
    )


def thrust_coefficient(propeller: Propeller) -> float:
    """Return the thrust over the squared speed [N s2]."""
    static = STATIC * sqrt(propeller.pitch / propeller.diameter) * (propeller.blades / 2.0) ** BLADES
    return static * DENSITY * propeller.diameter**4 / (2.0 * pi) ** 2


def torque_ratio(propeller: Propeller) -> float:
    """Return the torque per thrust [m] of a propeller at rest.

    It needs 1 / `MERIT` of the power of momentum theory.
    P = T sqrt(T / (2 rho A)) / M and Q = P / omega, so Q / T = sqrt(k / (2 rho A)) / M with k of T = k omega^2.
    """
    area = 0.25 * pi * propeller.diameter**2
    return sqrt(thrust_coefficient(propeller) / (2.0 * DENSITY * area)) / MERIT


def rotor_lag(propeller: Propeller) -> float:
    """Return the time constant [s] of a motor from its propeller's diameter."""
    return LAG * sqrt(propeller.diameter / LAG_AT)


def induced_speed(mass: float, propeller: Propeller) -> float:
    """Return the induced speed [m/s] of the rotors in hover by momentum theory."""
    return sqrt(mass * GRAVITY / (4.0 * 2.0 * DENSITY * 0.25 * pi * propeller.diameter**2))


def uncertainty(hover: bool) -> Uncertainty:
    """Return the uncertainty of an estimate; hover: whether the command at hover is known."""
    spreads = SPREADS | ({"thrust_coefficient": AT_HOVER} if hover else {})
    causes = sorted({cause for entry in spreads.values() for cause in entry})
    names = tuple(name for name in NAMES if name in spreads)
    loads = np.array([[spreads[name].get(cause, 0.0) for cause in causes] for name in names])
    return uncertainty_from(names, loads @ loads.T)


def _values(parts: PartsList, coefficient: float, full: float, *, lowered: bool) -> dict[str, Sourced]:
    arm, blade = 0.5 * parts.wheelbase, parts.propeller
    inertia = GYRATION * parts.mass * arm**2
    drag = parts.mass * GRAVITY / induced_speed(parts.mass, blade)
    speed = (
        f"{LOAD_FACTOR:g} times kv {parts.kv:g} rpm/V at {parts.cells} cells of {CELL_VOLTAGE:g} V: under load 0.45 to 0.95"
        if parts.hover is None
        else f"thrust at full command from hover at {parts.hover:g} of it"
    ) + (f"; lowered to a thrust to weight of {MAX_THRUST:g}" if lowered else "")
    numbers: dict[str, tuple[float, str, str]] = {
        "mass": (parts.mass, "kg", "given"),
        "arm": (arm, "m", "half the wheelbase given; a square X"),
        "thrust_coefficient": (
            coefficient,
            "N s2",
            "estimated: Staples' fit to bench data of propellers, D^3.5 P^0.5; its range holds that of speed_max",
        ),
        "torque_ratio": (
            torque_ratio(blade),
            "m",
            f"estimated: momentum theory at a figure of merit of {MERIT:g}, 0.3 to 0.65",
        ),
        "rotor_inertia": (
            ROTOR * blade.diameter**5,
            "kg m2",
            f"estimated: {ROTOR:g} kg/m3 D^5, propellers of one shape",
        ),
        "lag_up": (
            rotor_lag(blade),
            "s",
            f"estimated: {LAG:g} s at propellers of {LAG_AT:g} m, with the root of the diameter; coreless motors up to 0.1",
        ),
        "lag_down": (rotor_lag(blade), "s", "estimated: as lag_up"),
        "speed_min": (0.0, "rad/s", "0: no lower limit is known"),
        "speed_max": (full, "rad/s", f"estimated: {speed}"),
        "drag_height": (0.0, "m", "0: drag taken at the centre of mass"),
        "gravity": (GRAVITY, "m/s2", "standard gravity, rounded"),
        "inertia.x": (
            inertia,
            "kg m2",
            f"estimated: {GYRATION:g} mass times arm squared, of published airframes 0.17 to 0.39",
        ),
        "inertia.y": (inertia, "kg m2", "estimated: as for x"),
        "inertia.z": (2.0 * SHARE * inertia, "kg m2", f"estimated: {SHARE:g} of x + y"),
        "drag_linear.x": (SIDE_DRAG * drag, "N s/m", f"estimated: {SIDE_DRAG:g} weight over induced speed; no range"),
        "drag_linear.y": (SIDE_DRAG * drag, "N s/m", "estimated: as for x"),
        "drag_linear.z": (
            CLIMB_DRAG * drag,
            "N s/m",
            f"estimated: {CLIMB_DRAG:g} weight over induced speed, momentum theory of a climb",
        ),
    }
    zeros = {
        f"{group}.{axis}": unit
        for group, unit in (("drag_quadratic", "N s2/m2"), ("rate_damping", "N m s"))
        for axis in "xyz"
    }
    numbers |= {key: (0.0, unit, "0: nothing is known; 0 asks more of the controller") for key, unit in zeros.items()}
    return {key: Sourced(rounded(value), unit, source) for key, (value, unit, source) in numbers.items()}
