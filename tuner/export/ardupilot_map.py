"""Our PID as the parameters of ArduPilot Copter's cascade, and back.

Attitude and horizontal loops are P around PI, as in `pid_cascade`. The vertical loop is P around P around a PI on the measured
acceleration: with K the acceleration that an acceleration error gives [1] and Ki that of its integral [1/s],

    a = K (a_c - a) + Ki int (a_c - a),    a_c = p (q (r - z) - z')

    (1 + K) z'' + (K p + Ki) z' + (K p q + Ki p) z + Ki p q int z = disturbance

so its poles are those of our PID with kd = (K p + Ki)/(1 + K) and so on: K adds a virtual mass. K is chosen; then
K s^3 + (1 + K)(kd s^2 + kp s + ki) = (K s + Ki)(s^2 + p s + p q), and any real root -Ki/K of the cubic will do.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import degrees, radians

import numpy as np

from plant.airframes.actuation import Actuation
from plant.cascade import ATTITUDE_AXES
from plant.errors import InputError
from plant.laws.pid import Gains
from plant.vehicle import Vehicle
from tuner.export.ardupilot_ranges import Dialect
from tuner.export.autopilot_pid import axis_gains
from tuner.export.autopilot_scales import TorqueScale, ardupilot_factors, command_slope, hover_share, torque_scale
from tuner.export.parameter_table import misfit
from tuner.export.pid_cascade import RateLoop, parallel, rate_loop
from tuner.gains_file import Controller

GRAVITY = 9.80665
TARGET = "ArduPilot"
SHORT = {"roll": "RLL", "pitch": "PIT", "yaw": "YAW"}
# Imaginary parts below this share of the largest root are rounding.
REAL = 1e-9
# Integral limit of the horizontal velocity loop [m/s2]: the default, and as much as 45 deg of tilt give.
HORIZONTAL_LIMIT = 10.0


@dataclass(frozen=True)
class Vertical:
    """The vertical loop: K [1], Ki [1/s]; outer q [1/s], velocity p [1/s]."""

    accel: float
    accel_i: float
    outer: float
    p: float


@dataclass(frozen=True)
class ArdupilotScales:
    """torque for one unit [N m]; horizontal: what the vehicle accelerates by for 1 m/s2 of ArduPilot's [1]; climb: acceleration
    for the whole throttle [m/s2]; hover: throttle at hover [1].
    """

    torque: TorqueScale
    horizontal: float
    climb: float
    hover: float


def ardupilot_scales(vehicle: Vehicle, actuation: Actuation, model: float) -> ArdupilotScales:
    """Work out the scales; model: MOT_THST_EXPO."""
    slope = command_slope(actuation, model)
    torque = torque_scale(actuation, ardupilot_factors(actuation), slope, TARGET)
    return ArdupilotScales(torque, vehicle.gravity / GRAVITY, 4.0 * slope / vehicle.mass, hover_share(actuation, model))


def vertical_loops(gains: Gains, accel: float) -> tuple[Vertical, ...]:
    """Return every form of the vertical loop with K = accel, fastest acceleration loop first; none where there is none."""
    mass = 1.0 + accel
    roots = np.roots([accel, mass * gains.kd, mass * gains.kp, mass * gains.ki])
    real = sorted(float(root.real) for root in roots if abs(root.imag) <= REAL * np.max(np.abs(roots), axis=0))
    found = []
    for root in real:
        p = mass * gains.kd / accel + root
        product = mass * gains.kp / accel + root * p
        if p > 0.0 and product >= 0.0:
            found.append(Vertical(accel, -root * accel, product / p, p))
    return tuple(found)


def vertical_gains(loop: Vertical, t_f: float) -> Gains:
    """Return our gains with the poles of a vertical loop."""
    mass = 1.0 + loop.accel
    kp = (loop.accel * loop.p * loop.outer + loop.accel_i * loop.p) / mass
    return Gains(kp, loop.accel_i * loop.p * loop.outer / mass, (loop.accel * loop.p + loop.accel_i) / mass, t_f)


def loops(controller: Controller) -> dict[str, RateLoop]:
    """Return the cascaded form of every axis but z, x for both horizontal ones."""
    return {axis: rate_loop(axis_gains(controller, axis), axis) for axis in ("x", *ATTITUDE_AXES)}


def to_ardupilot(
    controller: Controller, actuation: Actuation, model: float, dialect: Dialect, accel_gain: float
) -> dict[str, float]:
    """Return the parameters in ArduPilot's units, unrounded; accel_gain: acceleration P gain as a share of the hover throttle,
    per 10 m/s2.

    Raises InputError where the gains have no such form.
    """
    vehicle = controller.airframe.vehicle
    scales = ardupilot_scales(vehicle, actuation, model)
    values: dict[str, float] = {}
    for axis, inertia, torque in zip(ATTITUDE_AXES, vehicle.inertia, scales.torque, strict=True):
        values |= _attitude(SHORT[axis], loops(controller)[axis], inertia / torque)
    values |= _horizontal(loops(controller)["x"], scales.horizontal, dialect)
    accel = 0.1 * accel_gain * scales.hover * scales.climb
    candidates = [_vertical(loop, scales.climb, dialect) for loop in vertical_loops(axis_gains(controller, "z"), accel)]
    if not candidates:
        raise InputError(
            f"kp, ki and kd of z have no form as position, velocity and acceleration loop with K = {accel:.3g}; allowed: a kd "
            "that damps more, or another --set accel_gain",
            key="z.kd",
        )
    values |= min(candidates, key=lambda found: misfit(dialect.table, found))
    return values | {
        "PSC_ANGLE_MAX": degrees(controller.options.tilt_limit),
        "MOT_THST_EXPO": model,
        "MOT_THST_HOVER": scales.hover,
    }


def _attitude(short: str, loop: RateLoop, scale: float) -> dict[str, float]:
    rate = f"ATC_RAT_{short}"
    off = ("D", "FF", "D_FF", "FLTE", "SMAX")
    return {
        f"ATC_ANG_{short}_P": loop.outer,
        f"{rate}_P": scale * loop.p,
        f"{rate}_I": scale * loop.i,
        f"{rate}_IMAX": 1.0,
        f"{rate}_FLTT": 50.0 if short == "YAW" else 100.0,
        **{f"{rate}_{term}": 0.0 for term in off},
    }


def _horizontal(loop: RateLoop, scale: float, dialect: Dialect) -> dict[str, float]:
    roles = {
        "xy_p": loop.outer, "vxy_p": loop.p / scale, "vxy_i": loop.i / scale, "vxy_d": 0.0, "vxy_ff": 0.0, "vxy_flte": 0.0,
        "vxy_imax": dialect.metre * HORIZONTAL_LIMIT,
    }  # fmt: skip
    return {dialect.names[role]: value for role, value in roles.items()}


def _vertical(loop: Vertical, climb: float, dialect: Dialect) -> dict[str, float]:
    scale = dialect.acceleration * climb
    roles = {
        "z_p": loop.outer, "vz_p": loop.p, "vz_i": 0.0, "vz_d": 0.0, "vz_ff": 0.0, "vz_flte": 0.0,
        "az_p": loop.accel / scale, "az_i": loop.accel_i / scale, "az_d": 0.0, "az_ff": 0.0, "az_imax": dialect.whole,
    }  # fmt: skip
    return {dialect.names[role]: value for role, value in roles.items()}


def held_vertical(values: Mapping[str, float], scales: ArdupilotScales, dialect: Dialect) -> Vertical:
    """Return the vertical loop of parameters."""
    scale = dialect.acceleration * scales.climb
    accel, accel_i, outer, p = (values[dialect.names[role]] for role in ("az_p", "az_i", "z_p", "vz_p"))
    return Vertical(scale * accel, scale * accel_i, outer, p)


def from_ardupilot(
    values: Mapping[str, float], vehicle: Vehicle, actuation: Actuation, dialect: Dialect, filters: Mapping[str, float]
) -> dict[str, Gains]:
    """Return our gains for parameters of ArduPilot; filters: t_f by axis [s]. D and FF terms do not enter."""
    scales = ardupilot_scales(vehicle, actuation, values["MOT_THST_EXPO"])
    gains: dict[str, Gains] = {}
    for axis, inertia, torque in zip(ATTITUDE_AXES, vehicle.inertia, scales.torque, strict=True):
        rate, scale = f"ATC_RAT_{SHORT[axis]}", torque / inertia
        loop = RateLoop(values[f"ATC_ANG_{SHORT[axis]}_P"], scale * values[f"{rate}_P"], scale * values[f"{rate}_I"])
        gains[axis] = parallel(loop, filters[axis])
    outer, p, i = (values[dialect.names[role]] for role in ("xy_p", "vxy_p", "vxy_i"))
    horizontal = RateLoop(outer, scales.horizontal * p, scales.horizontal * i)
    gains |= {axis: parallel(horizontal, filters[axis]) for axis in ("x", "y")}
    return gains | {"z": vertical_gains(held_vertical(values, scales, dialect), filters["z"])}


def tilt_limit(values: Mapping[str, float]) -> float:
    """Return the largest tilt [rad] of PSC_ANGLE_MAX above 0."""
    return radians(values["PSC_ANGLE_MAX"])
