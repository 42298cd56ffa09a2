"""Estimated parameters of a vehicle: names, units, what is known beforehand, and the physical numbers at a point.

A point is a vector of coordinates that are near normal: logarithms of positive numbers, offsets and biases as they are.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import exp, hypot, log, pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plant.quadrotor.vehicle import Vehicle
from plant.vectors import Vec3
from tuner.extensions.vehicle_fit.random_effects import FlightEstimate

Array = NDArray[np.float64]

NODES = np.array([0.3, 0.65, 1.0])
"""Motor commands whose thrusts are the parameters of the thrust curve, a parabola through them."""
THRUSTS = tuple(f"thrust.{100.0 * u:.0f}" for u in NODES.tolist())
"""Names of these thrusts."""
_CURVE = np.linalg.inv(np.vander(NODES, 3, increasing=True))


class Parameter(NamedTuple):
    """One coordinate: name, unit, prior value, prior standard deviation (relative where `positive`), and what it means."""

    name: str
    unit: str
    value: float
    deviation: float
    positive: bool
    meaning: str

    @property
    def coordinate(self) -> float:
        """The prior's center as a coordinate."""
        return log(self.value) if self.positive else self.value

    def number(self, coordinate: float) -> float:
        """Return the physical number at a coordinate."""
        return exp(coordinate) if self.positive else coordinate


class PhysicalParameters(NamedTuple):
    """Physical numbers of a point, SI units.

    Attributes:
        arm: Factor on the places of the rotors.
        thrust (3,): At `NODES`.
        center: Center of mass in the frame of the rotors, x and y.
        climb_drag: Drag of a climb, along z.
        rate_damping: Damping of roll and pitch rates.
        rotor: Factor on the inertia of a rotor.
        gyro_delay: Delay of the gyro's second-order low-pass at low frequencies.
        lift_bias (logs,): Bias of the accelerometer along z.
        yaw_bias (logs,): Constant torque.
        sag (logs,): Share of the thrust that is lost from begin to end.
    """

    mass: float
    arm: float
    inertia: Vec3
    thrust: Array
    lag_up: float
    lag_down: float
    dead_time: float
    center: tuple[float, float]
    torque_ratio: float
    climb_drag: float
    rate_damping: float
    rotor: float
    gyro_delay: float
    lift_bias: Array
    yaw_bias: Array
    sag: Array

    @property
    def curve(self) -> Array:
        """Coefficients (3,) of the thrust of a rotor [N] over the command: constant, linear, quadratic."""
        return _CURVE @ self.thrust


MASS, ARM = 0.02, 0.02
"""Usual standard deviations of what people measure themselves, relative."""
ROTOR, INFLOW = 0.3, 0.5
"""Prior standard deviations of the inertia of a rotor, and of the damping of roll and pitch by rotors that climb as the vehicle
turns, relative.
"""
WIDE, LAG, SHARE = 0.5, 1.0, 0.12
"""Prior standard deviations of inertias and thrusts, of lags, and of the inertia about z over the sum of the others, which is
between 0.6 and 1: logarithms; 1 is a factor of e either way.
"""
GYRO_DELAY, GYRO_SPREAD, GYRO_READ = 0.0015, 0.8, 0.2
"""Delay of a gyro's low-pass [s] where the airframe names no cut-off, here 150 Hz, and its logarithm's prior standard deviation:
then, 30 to 700 Hz, and where it does.
"""
DEAD_TIME, CENTRE = 0.01, 0.1
"""Prior standard deviations of the dead time [s], and of the centre of mass as a share of the arm."""
LIFT_BIAS, SAG = 0.15, 0.2
"""Prior standard deviations of the accelerometer's bias [m/s2], and of the change of thrust over a log, relative."""
MIN_DRAG = 0.05
"""Drag over mass that the prior begins at where the airframe has less [1/s]."""
NUISANCES = 3
"""Coordinates that belong to a log."""


@dataclass(frozen=True, eq=False)
class EarlierPosterior:
    """Posterior of earlier logs.

    Attributes:
        names: Names (n,) of the coordinates.
        point: Mean (n,).
        covariance: Covariance (n, n).
        initial_std: Standard deviations (n,) before any log.
        flights: Estimates from each flight alone.
    """

    names: tuple[str, ...]
    point: Array
    covariance: Array
    initial_std: Array
    flights: tuple[FlightEstimate, ...] = ()

    def without(self, names: Collection[str]) -> "EarlierPosterior":
        """Return the posterior with some parameters as wide as initially."""
        is_changed = np.array([name in names for name in self.names])
        covariance = np.where(is_changed[:, None] | is_changed, 0.0, self.covariance)
        covariance += np.diag(np.where(is_changed, self.initial_std**2, 0.0))
        flights = tuple(flight.without(names) for flight in self.flights)
        return replace(self, covariance=covariance, flights=flights)


class WeighedPrior(NamedTuple):
    """Prior after the weight.

    Attributes:
        covariance: Covariance (n, n).
        before: The space before the weight.
    """

    covariance: Array
    before: "ParameterSpace"


@dataclass(frozen=True, eq=False)
class ParameterSpace:
    """Coordinates of a vehicle and its logs, with their prior; the last are nuisances, `NUISANCES` for each log.

    earlier: posterior of earlier logs, None where there are none. weighed: prior conditioned on the weight, None where it is not.
    """

    parameters: tuple[Parameter, ...]
    logs: int
    earlier: EarlierPosterior | None = None
    weighed: "WeighedPrior | None" = None

    @property
    def names(self) -> tuple[str, ...]:
        """Names in the order of the coordinates."""
        return tuple(entry.name for entry in self.parameters)

    @property
    def center(self) -> Array:
        """The prior's center (n,)."""
        return np.array([entry.coordinate for entry in self.parameters])

    @property
    def prior_std(self) -> Array:
        """The prior's standard deviations (n,) of the coordinates."""
        return np.array([entry.deviation for entry in self.parameters])

    @cached_property
    def covariance(self) -> Array:
        """The prior's covariance (n, n)."""
        if self.weighed is not None:
            return self.weighed.covariance
        covariance = np.diag(self.prior_std**2)
        if self.earlier is not None:
            covariance[: self.physical, : self.physical] = self.earlier.covariance
        return covariance

    @cached_property
    def precision(self) -> Array:
        """The inverse (n, n) of the prior's covariance."""
        if self.earlier is None and self.weighed is None:
            return np.diag(self.prior_std**-2.0)
        return np.asarray(np.linalg.inv(self.covariance), np.float64)

    @property
    def initial_std(self) -> Array:
        """Standard deviations (n,) before any log, against which identifiability is judged."""
        if self.weighed is not None:
            return self.weighed.before.initial_std
        std = self.prior_std
        if self.earlier is not None:
            std[: self.physical] = self.earlier.initial_std
        return std

    def with_prior(self, earlier: EarlierPosterior) -> "ParameterSpace":
        """Return the space with the posterior of earlier logs as its prior."""
        first = _centered(self.parameters[: self.physical], earlier.point, earlier.covariance)
        return ParameterSpace((*first, *self.parameters[self.physical :]), self.logs, earlier)

    def conditioned(self, point: Array, covariance: Array) -> "ParameterSpace":
        """Return the space after the weight.

        point, covariance: mean (n,) and covariance (n, n) of its prior.
        """
        return replace(
            self, parameters=_centered(self.parameters, point, covariance), weighed=WeighedPrior(covariance, self)
        )

    @property
    def unweighed(self) -> "ParameterSpace":
        """The space before the weight."""
        return self if self.weighed is None else self.weighed.before

    @property
    def physical(self) -> int:
        """Number of coordinates of the vehicle, without those of logs."""
        return len(self.parameters) - NUISANCES * self.logs

    def numbers(self, point: Array) -> PhysicalParameters:
        """Return the physical parameters of a point (n,)."""
        v = [entry.number(value) for entry, value in zip(self.parameters, point.tolist(), strict=True)]
        biases = np.array(v[self.physical :]).reshape(self.logs, NUISANCES)
        return PhysicalParameters(
            v[0],
            v[1],
            Vec3(v[2], v[3], v[4] * (v[2] + v[3])),
            np.array(v[5:8]),
            v[8],
            v[9],
            v[10],
            (v[11], v[12]),
            v[13],
            v[14],
            v[15],
            v[16],
            v[17],
            *biases.T,
        )


def _centered(parameters: Sequence[Parameter], point: Array, covariance: Array) -> tuple[Parameter, ...]:
    """Return parameters whose prior has a mean (n,) and covariance (n, n)."""
    prior_std = np.sqrt(np.diag(covariance)).tolist()
    return tuple(
        entry._replace(value=entry.number(value), deviation=deviation)
        for entry, value, deviation in zip(parameters, point.tolist(), prior_std, strict=True)
    )


def _gyro_delay(cutoff: float) -> Parameter:
    """Return the coordinate of the gyro's delay; cutoff: of its low-pass [Hz], 0 where it is unknown."""
    value, deviation = (low_pass_delay(cutoff), GYRO_READ) if cutoff > 0.0 else (GYRO_DELAY, GYRO_SPREAD)
    return Parameter("gyro_delay", "s", value, deviation, True, "delay of the gyro's low-pass")


def low_pass_delay(cutoff: float) -> float:
    """Return the delay [s] of a second-order Butterworth low-pass at low frequencies.

    Its own inverse: of a delay it returns the cut-off [Hz].
    """
    return sqrt(2.0) / (2.0 * pi * cutoff)


def space_of(vehicle: Vehicle, logs: Sequence[str], mass: float = MASS, arm: float = ARM) -> ParameterSpace:
    """Return the coordinates for a vehicle; logs: their names; mass, arm: relative standard deviations of the two."""
    full = vehicle.thrust_coefficient * vehicle.speed_max**2
    lever = hypot(vehicle.rotor_x.r1, vehicle.rotor_y.r1)
    torque = vehicle.mass * vehicle.gravity * vehicle.torque_ratio
    climb_drag = max(vehicle.drag_linear.z, MIN_DRAG * vehicle.mass)
    # A rotor loses thrust to a climb of its own, whether the vehicle climbs or rolls.
    damping = max(vehicle.rate_damping.x, vehicle.rate_damping.y, 0.5 * climb_drag * lever**2)
    inertia = vehicle.inertia._asdict()
    entries = [
        Parameter("mass", "kg", vehicle.mass, mass, True, "mass in flight"),
        Parameter("arm", "1", 1.0, arm, True, "factor on the lengths from the middle to the rotors"),
        *[Parameter(f"inertia.{a}", "kg m2", inertia[a], WIDE, True, f"moment of inertia about {a}") for a in "xy"],
        Parameter(
            "inertia_share",
            "1",
            inertia["z"] / (inertia["x"] + inertia["y"]),
            SHARE,
            True,
            "of inertia about z in that about x and y",
        ),
        *[
            Parameter(
                name,
                "N",
                full * u * (u + vehicle.thrust_linear * (1.0 - u)),
                WIDE,
                True,
                f"thrust of a rotor at {100 * u:.0f} % command",
            )
            for name, u in zip(THRUSTS, NODES.tolist(), strict=True)
        ],
        Parameter("lag_up", "s", vehicle.lag_up, LAG, True, "time constant of a rotor that speeds up"),
        Parameter("lag_down", "s", vehicle.lag_down, LAG, True, "time constant of a rotor that slows down"),
        Parameter("dead_time", "s", vehicle.dead_time, DEAD_TIME, False, "from a logged command to the rotor"),
        *[Parameter(f"centre.{a}", "m", 0.0, CENTRE * lever, False, f"centre of mass along {a}") for a in "xy"],
        Parameter("torque_ratio", "m", vehicle.torque_ratio, WIDE, True, "yaw torque of a rotor per thrust"),
        Parameter("drag_linear.z", "N s/m", climb_drag, LAG, True, "drag of a climb"),
        Parameter("rate_damping", "N m s", damping, INFLOW, True, "damping of roll and pitch"),
        Parameter("rotor_inertia", "1", 1.0, ROTOR, True, "factor on the inertia of a rotor"),
        _gyro_delay(vehicle.gyro_cutoff),
    ]
    for name in logs:
        entries += [
            Parameter(f"lift_bias({name})", "m/s2", 0.0, LIFT_BIAS, False, "bias of the accelerometer along z"),
            Parameter(f"yaw_bias({name})", "N m", 0.0, torque, False, "constant yaw torque"),
            Parameter(f"sag({name})", "1", 0.0, SAG, False, "share of the thrust lost from begin to end"),
        ]
    return ParameterSpace(tuple(entries), len(logs))
