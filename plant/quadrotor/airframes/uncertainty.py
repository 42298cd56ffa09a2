"""The [uncertainty] of an airframe file: how far its numbers are known, together.

    [uncertainty]
    source = "identified from log15"
    names = ["mass", "inertia.x", "inertia.y"]
    deviations = [0.02, 0.034, 0.034]
    correlation = [[1.0, 0.6, 0.6], [0.6, 1.0, 0.9], [0.6, 0.9, 1.0]]

Deviations are standard deviations: of a positive number relative, of a place of the centre of mass in m, of the dead time in s,
of thrust_linear as it is. Logarithms of positive numbers are normal, so none is drawn below zero; a dead time below zero counts
as 0. NumPy is imported where there is an uncertainty: loading an airframe needs none.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import exp, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plant.errors import InputError, check_name
from plant.quadrotor.airframes.rules import THRUST_TO_WEIGHT, thrust_to_weight, torque_ratios
from plant.quadrotor.thrust_curve import MAX_LINEAR, MIN_LINEAR
from plant.quadrotor.vehicle import Vehicle
from plant.vectors import Rotors, Vec3

if TYPE_CHECKING:
    import numpy as np

POSITIVE = (
    "mass",
    "arm",
    "inertia.x",
    "inertia.y",
    "inertia.z",
    "thrust_coefficient",
    "torque_ratio",
    "lag_up",
    "lag_down",
    "drag_linear.z",
    "rate_damping",
    "rotor_inertia",
)
"""Numbers with relative deviations; `arm` is a factor on the places of all rotors, `rate_damping` one on x and y."""
CENTRE = ("centre.x", "centre.y")
"""Places of the centre of mass in the frame of the rotors, 0 as the file has it [m]."""
ADDED = ("thrust_linear", "dead_time")
"""Other numbers whose deviations add to those of the file; a curve that is drawn must have one in the file."""
NAMES = (*POSITIVE, *CENTRE, *ADDED)
KEYS = ("source", "names", "deviations", "correlation")
LARGEST_RELATIVE, LARGEST_ADDED = 1.0, {"centre.x": 1.0, "centre.y": 1.0, "thrust_linear": 1.0, "dead_time": 0.1}
MAX_TRIES = 1000
# Distance of the extremes along a principal axis, in standard deviations.
FAR = 2.0


@dataclass(frozen=True)
class Uncertainty:
    """Standard deviations of numbers of a vehicle, and their correlation; see the module for their units."""

    names: tuple[str, ...]
    deviations: tuple[float, ...]
    correlation: tuple[tuple[float, ...], ...]

    @cached_property
    def axes(self) -> "np.ndarray":
        """Principal axes (n, n) as columns, each as long as its standard deviation, the longest first."""
        import numpy as np

        from plant.quadrotor.airframes.principal_axes import principal_axes

        sizes = np.array(self.deviations)
        return principal_axes(np.array(self.correlation) * np.outer(sizes, sizes))

    def draw(self, vehicle: Vehicle, generator: "np.random.Generator") -> Vehicle:
        """Return a vehicle about the given one; InputError where none of many that are drawn can exist."""
        return self.moved(vehicle, self.step(vehicle, generator))

    def step(self, vehicle: Vehicle, generator: "np.random.Generator") -> "np.ndarray":
        """Return the deviation (n,) of a sampled vehicle that can exist; InputError where none of many can."""
        for _ in range(MAX_TRIES):
            deviation = self.axes @ generator.standard_normal(len(self.names))
            if can_exist(self.moved(vehicle, deviation)):
                return deviation
        raise InputError(
            f"none of {MAX_TRIES} vehicles drawn from it can exist, for the inertia about z exceeds the sum of the others, or "
            "the thrust does not lift it; make the deviations smaller or correct the numbers",
            key="uncertainty",
        )

    def extremes(self, vehicle: Vehicle) -> tuple[Vehicle, ...]:
        """Return the vehicles at +-2 standard deviations along each principal axis that can exist."""
        ends = [self.moved(vehicle, sign * FAR * axis) for axis in self.axes.T for sign in (-1.0, 1.0)]
        return tuple(entry for entry in ends if can_exist(entry))

    def moved(self, vehicle: Vehicle, by: "np.ndarray") -> Vehicle:
        """Return the vehicle moved by (n,): logarithms of factors, places [m], and what is `ADDED`."""
        step = dict.fromkeys(NAMES, 0.0) | dict(zip(self.names, by.tolist(), strict=True))
        f = {name: exp(step[name]) for name in POSITIVE}
        inertia, drag, damping = vehicle.inertia, vehicle.drag_linear, vehicle.rate_damping
        x, y = step["centre.x"], step["centre.y"]
        return vehicle._replace(
            mass=vehicle.mass * f["mass"],
            inertia=Vec3(inertia.x * f["inertia.x"], inertia.y * f["inertia.y"], inertia.z * f["inertia.z"]),
            rotor_x=Rotors(*[f["arm"] * place - x for place in vehicle.rotor_x]),
            rotor_y=Rotors(*[f["arm"] * place - y for place in vehicle.rotor_y]),
            thrust_coefficient=vehicle.thrust_coefficient * f["thrust_coefficient"],
            torque_ratio=vehicle.torque_ratio * f["torque_ratio"],
            rotor_inertia=vehicle.rotor_inertia * f["rotor_inertia"],
            lag_up=vehicle.lag_up * f["lag_up"],
            lag_down=vehicle.lag_down * f["lag_down"],
            drag_linear=drag._replace(z=drag.z * f["drag_linear.z"]),
            rate_damping=damping._replace(x=damping.x * f["rate_damping"], y=damping.y * f["rate_damping"]),
            thrust_linear=vehicle.thrust_linear + step["thrust_linear"],
            dead_time=max(vehicle.dead_time + step["dead_time"], 0.0),
        )


def can_exist(vehicle: Vehicle) -> bool:
    """Return True if a vehicle can exist and take off.

    By its inertias, and by torque and curve of its thrust.
    """
    x, y, z = vehicle.inertia
    low, high = torque_ratios(vehicle)
    flies = thrust_to_weight(vehicle) >= THRUST_TO_WEIGHT[0] and MIN_LINEAR < vehicle.thrust_linear <= MAX_LINEAR
    return flies and max(x, y, z) <= 0.5 * (x + y + z) * (1.0 + 1e-12) and low <= vehicle.torque_ratio <= high


def read_uncertainty(table: Mapping[str, Any], file: Path) -> Uncertainty | None:
    """Return the uncertainty of an airframe's table, None where it has none; InputError names file and key."""
    given = table.get("uncertainty")
    if given is None:
        return None
    if not isinstance(given, dict):
        raise InputError("it must be a table [uncertainty]", file=file, key="uncertainty")
    for key in given:
        check_name("key", key, KEYS, file=file, key=f"uncertainty.{key}")
    names = _names(given.get("names"), file)
    deviations = _numbers(given.get("deviations"), len(names), "deviations", file)
    for name, value in zip(names, deviations, strict=True):
        most = LARGEST_ADDED.get(name, LARGEST_RELATIVE)
        if not 0.0 < value <= most:
            raise InputError(
                f"given {value:g} for {name}; allowed: above 0, up to {most:g}", file=file, key="uncertainty.deviations"
            )
    rows = given.get("correlation")
    if not isinstance(rows, list) or len(rows) != len(names):
        raise InputError(
            f"must have a row for each of the {len(names)} names", file=file, key="uncertainty.correlation"
        )
    correlation = tuple(_numbers(row, len(names), "correlation", file) for row in rows)
    _check_correlation(correlation, file)
    return Uncertainty(names, deviations, correlation)


def _names(given: Any, file: Path) -> tuple[str, ...]:
    if not isinstance(given, list) or not given or not all(isinstance(name, str) for name in given):
        raise InputError(f"must be a list of names, of {', '.join(NAMES)}", file=file, key="uncertainty.names")
    for name in given:
        check_name("name", name, NAMES, file=file, key="uncertainty.names")
    if len(set(given)) < len(given):
        raise InputError("has a name twice; leave one out", file=file, key="uncertainty.names")
    return tuple(given)


def _numbers(given: Any, count: int, key: str, file: Path) -> tuple[float, ...]:
    if not isinstance(given, list) or len(given) != count or not all(_is_number(value) for value in given):
        raise InputError(f"must be {count} finite numbers, one for each name", file=file, key=f"uncertainty.{key}")
    return tuple(float(value) for value in given)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)


def _check_correlation(rows: tuple[tuple[float, ...], ...], file: Path) -> None:
    import numpy as np

    matrix, key = np.array(rows), "uncertainty.correlation"
    if np.any(np.abs(np.diag(matrix) - 1.0) > 1e-9) or np.any(np.abs(matrix) > 1.0 + 1e-9):
        raise InputError("must have ones on its diagonal and numbers from -1 to 1 elsewhere", file=file, key=key)
    if np.any(np.abs(matrix - matrix.T) > 1e-9):
        raise InputError("is not symmetric; rows i and j need equal entries for the names i and j", file=file, key=key)
    least = float(np.linalg.eigvalsh(matrix)[0])
    if least < -1e-6:
        raise InputError(
            f"has an eigenvalue of {least:.3g}, and no numbers vary like that; correct it (identified ones have none below 0)",
            file=file,
            key=key,
        )
