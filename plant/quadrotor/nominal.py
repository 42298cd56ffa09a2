"""The controller's knowledge of the vehicle: nominal numbers, rotor allocation, actuator model and options."""

from dataclasses import dataclass
from math import exp, hypot, inf, pi, sqrt, tan
from typing import NamedTuple

import numpy as np

from plant.errors import InputError
from plant.quadrotor.battery import Battery, battery_of
from plant.quadrotor.gyro import GyroPath, gyro_path
from plant.quadrotor.notches import MAX_NOTCHES, RpmNotches, rpm_notches
from plant.quadrotor.thrust_curve import CommandCurve, command_curve
from plant.quadrotor.vehicle import Vehicle
from plant.vectors import Rotors, Vec3

# Cut-off of the low-pass on the yaw torque [Hz]; PX4's MC_YAW_TQ_CUTOFF goes from 0 to 10.
MIN_CUTOFF, MAX_CUTOFF = 0.1, 100.0
NOTCH_RANGES = {"rpm_notches": (0, MAX_NOTCHES), "rpm_notch_q": (0.5, 30.0), "rpm_notch_min": (10.0, 1000.0)}
"""Allowed numbers of the notches that follow the rotors; the last in Hz."""
BATTERY_RANGES = {"battery_compensation": (0.0, 1.0), "battery_cutoff": (0.05, 100.0)}
"""Allowed numbers of the compensation of a battery's sag; the last in Hz."""


class Allocation(NamedTuple):
    """Thrust of each rotor [N] for one unit of: total thrust [N]; roll, pitch, yaw torque [N m]. Inverse of the mixer."""

    thrust: Rotors
    roll: Rotors
    pitch: Rotors
    yaw: Rotors


class Nominal(NamedTuple):
    """The vehicle in its controller's model.

    Attributes:
        vehicle: nominal numbers.
        allocation: see there.
        yaw_reach: yaw torque for one unit of thrust of each rotor [m].
        hover: thrust of one rotor at hover [N].
        thrust_min, thrust_max of one rotor [N].
        lag_step: share of a rotor-thrust step that is reached after one control period.
        lag_missing: mean missing share over that period.
        tilt_tangent: tangent of the largest commanded tilt.
        attitude_observer, position_observer: 1 where that loop takes rates from its observer.
        position_achieved: 1 where the position observers are fed with the acceleration that the measured tilt and
            modelled thrust achieve, 0 for the one commanded.
        delay: 1 for one period of compute delay.
        yaw_smoothing: share of a new yaw torque that a period of its low-pass takes over, 1 without.
        gyro: path of the gyro, which flies with the vehicle and is in no law's model.
        notches, harmonics: those that follow the rotors, and at how many harmonics.
        battery: the one that flies, and its compensation.
        curve: curve of rotor speed over its command, which the controller inverts.
    """

    vehicle: Vehicle
    allocation: Allocation
    yaw_reach: Rotors
    hover: float
    thrust_min: float
    thrust_max: float
    lag_step: float
    lag_missing: float
    tilt_tangent: float
    attitude_observer: float
    position_observer: float
    position_achieved: float
    delay: float
    yaw_smoothing: float
    gyro: GyroPath
    notches: RpmNotches
    harmonics: float
    battery: Battery
    curve: CommandCurve


@dataclass(frozen=True)
class ControlOptions:
    """Choices that are not gains.

    Attributes:
        attitude_rate, position_rate: "measured" (gyro, velocity) or "observer".
        lag_aware: the observers are fed with the modelled (lagged, clipped) actuator output instead of the
            clipped command.
        delay: the command acts one control period after its measurement.
        tilt_limit: largest commanded tilt [rad].
        yaw_torque_cutoff: cut-off of the low-pass on the yaw torque [Hz], 0 for none; where rotors are heavy
            their own angular momentum makes yaw lead, and this takes the lead back.
        rpm_notches: harmonics of each rotor's measured speed that are taken out of the gyro
            (`plant.quadrotor.notches`), 0 for none.
        rpm_notch_q: their quality.
        rpm_notch_min: frequency below which there is none [Hz].
        battery_compensation: share of the sag of a battery that commands are raised by
            (`plant.quadrotor.battery`).
        battery_cutoff: cut-off of the low-pass on its voltage [Hz].
    """

    attitude_rate: str = "measured"
    position_rate: str = "measured"
    lag_aware: bool = True
    delay: bool = False
    tilt_limit: float = 0.5236
    yaw_torque_cutoff: float = 0.0
    rpm_notches: int = 0
    rpm_notch_q: float = 5.0
    rpm_notch_min: float = 100.0
    battery_compensation: float = 0.0
    battery_cutoff: float = 5.0

    def __post_init__(self) -> None:
        for key in ("attitude_rate", "position_rate"):
            if getattr(self, key) not in ("measured", "observer"):
                raise InputError(f"given '{getattr(self, key)}'; allowed: 'measured', 'observer'", key=key)
        if not 0.05 <= self.tilt_limit <= 1.05:
            raise InputError(f"given {self.tilt_limit} rad; allowed: 0.05 to 1.05 rad (3 to 60 deg)", key="tilt_limit")
        if self.yaw_torque_cutoff != 0.0 and not MIN_CUTOFF <= self.yaw_torque_cutoff <= MAX_CUTOFF:
            raise InputError(
                f"given {self.yaw_torque_cutoff} Hz; allowed: {MIN_CUTOFF:g} to {MAX_CUTOFF:g} Hz, or 0 for no filter",
                key="yaw_torque_cutoff",
            )
        for key, (least, most) in {**NOTCH_RANGES, **BATTERY_RANGES}.items():
            if not least <= getattr(self, key) <= most:
                raise InputError(f"given {getattr(self, key):g}; allowed: {least:g} to {most:g}", key=key)


def yaw_lead(vehicle: Vehicle) -> float:
    """Frequency [rad/s] above which accelerating rotors turn the body in yaw more than their drag does: 2 k_m w_hover / J.

    The zero of yaw torque at hover, (1 + s/yaw_lead)/(1 + tau s); infinite for rotors without inertia.
    """
    hover = sqrt(0.25 * vehicle.mass * vehicle.gravity / vehicle.thrust_coefficient)
    drag = 2.0 * vehicle.thrust_coefficient * vehicle.torque_ratio * hover
    return drag / vehicle.rotor_inertia if vehicle.rotor_inertia > 0.0 else inf


def yaw_smoothing(cutoff: float, h: float) -> float:
    """Share of a new value that a first-order low-pass takes over in a period h [s]: h/(h + tau), tau = 1/(2 pi cutoff [Hz]).

    The form of PX4's AlphaFilter, which passes everything where the cutoff is 0 or reaches half the control rate.
    """
    return h / (h + 0.5 / (pi * cutoff)) if 0.0 < cutoff < 0.5 / h else 1.0


def mixer_matrix(vehicle: Vehicle) -> np.ndarray:
    """Matrix (4, 4) from rotor thrusts [N] to total thrust [N] and roll, pitch, yaw torque [N m]."""
    return np.array(
        [
            np.ones(4),
            np.array(vehicle.rotor_y),
            -np.array(vehicle.rotor_x),
            vehicle.torque_ratio * np.array(vehicle.spin),
        ]
    )


def nominal(vehicle: Vehicle, options: ControlOptions, control_period: float) -> Nominal:
    """Work out everything the cascade needs to know of the vehicle at a control period [s]."""
    inverse = np.linalg.inv(mixer_matrix(vehicle))
    lag = 0.5 * (vehicle.lag_up + vehicle.lag_down)
    reached = 1.0 - exp(-control_period / lag)
    k_f = vehicle.thrust_coefficient
    return Nominal(
        vehicle=vehicle,
        allocation=Allocation(*[Rotors(*map(float, inverse[:, column])) for column in range(4)]),
        yaw_reach=Rotors(*[1.0 / abs(float(entry)) for entry in inverse[:, 3]]),
        hover=0.25 * vehicle.mass * vehicle.gravity,
        thrust_min=k_f * vehicle.speed_min**2,
        thrust_max=k_f * vehicle.speed_max**2,
        lag_step=reached if options.lag_aware else 1.0,
        lag_missing=reached * lag / control_period if options.lag_aware else 0.0,
        tilt_tangent=tan(options.tilt_limit),
        attitude_observer=float(options.attitude_rate == "observer"),
        position_observer=float(options.position_rate == "observer"),
        position_achieved=float(options.lag_aware),
        delay=float(options.delay),
        yaw_smoothing=yaw_smoothing(options.yaw_torque_cutoff, control_period),
        gyro=gyro_path(vehicle, control_period),
        notches=rpm_notches(options.rpm_notch_q, options.rpm_notch_min, control_period),
        harmonics=float(options.rpm_notches),
        battery=battery_of(vehicle, options.battery_compensation, options.battery_cutoff, control_period),
        curve=command_curve(vehicle.thrust_linear, vehicle.speed_max),
    )


def vary(vehicle: Vehicle, mass: float, inertia: float, thrust: float, lag: float) -> Vehicle:
    """Return the vehicle with mass, inertia, thrust coefficient and rotor lags multiplied by the given factors."""
    return vehicle._replace(
        mass=vehicle.mass * mass,
        inertia=Vec3(*[inertia * part for part in vehicle.inertia]),
        thrust_coefficient=vehicle.thrust_coefficient * thrust,
        lag_up=vehicle.lag_up * lag,
        lag_down=vehicle.lag_down * lag,
    )


def arm_of(vehicle: Vehicle) -> float:
    """Distance of rotor 1 from the middle of the rotors [m]."""
    x, y = vehicle.rotor_x, vehicle.rotor_y
    return hypot(x.r1 - 0.25 * sum(x), y.r1 - 0.25 * sum(y))


def shift_center_of_mass(vehicle: Vehicle, x: float, y: float) -> Vehicle:
    """Return the vehicle with its centre of mass moved by (x, y) in the body [m]; its inertias are then about that centre.

    The rotors sit elsewhere about it, so thrust turns the body; drag goes on acting above the centre of mass.
    """
    return vehicle._replace(
        rotor_x=Rotors(*[place - x for place in vehicle.rotor_x]),
        rotor_y=Rotors(*[place - y for place in vehicle.rotor_y]),
    )
