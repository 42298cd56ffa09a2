"""Our PID as the parameters of ArduPilot Copter's cascade, and back.

Attitude and horizontal loops are P around PI, as in `autopilot.pid`. The vertical loop is P around P around a PI on the measured
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
from tuner.exchange.ardupilot.ranges import Dialect
from tuner.exchange.autopilot.parameters import defaults, misfit
from tuner.exchange.autopilot.pid import (
    SAME,
    RateLoop,
    axis_gains,
    held_tilt,
    parallel,
    rate_loop,
    same_feedback,
    weighted,
    written_cutoff,
)
from tuner.exchange.autopilot.scales import TorqueScale, ardupilot_factors, command_slope, hover_share, torque_scale
from tuner.gains import Controller

GRAVITY = 9.80665
NAME = "ArduPilot"
EXPO, TILT = "MOT_THST_EXPO", "PSC_ANGLE_MAX"
# Low-pass of the rate error of yaw: with neither D nor FF the same as one on the torque.
YAW_FILTER = "ATC_RAT_YAW_FLTE"
# Parameter of the largest lean angle where PSC_ANGLE_MAX is 0 -> its unit in degrees; both default to 30 deg.
LEAN = {"4.6": ("ANGLE_MAX", 0.01, 3000.0), "4.7": ("ATC_ANGLE_MAX", 1.0, 30.0)}
# Terms of the position loops that ours have not.
OFF_ROLES = ("vxy_d", "vxy_ff", "vxy_flte", "vz_i", "vz_d", "vz_ff", "vz_flte", "az_d", "az_ff")
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
    torque = torque_scale(actuation, ardupilot_factors(actuation), slope, NAME)
    return ArdupilotScales(torque, vehicle.gravity / GRAVITY, 4.0 * slope / vehicle.mass, hover_share(actuation, model))


def vertical_loops(gains: Gains, accel: float, present: Vertical | None = None) -> tuple[Vertical, ...]:
    """Return every form of the vertical loop with K = accel, fastest acceleration loop first; none where there is none.

    present: the form on the vehicle; where it gives these gains it is the only one, otherwise the one nearest to it comes first.
    """
    if present is not None and present.accel == accel and same_feedback(vertical_gains(present, gains.t_f), gains):
        return (present,)
    if accel <= 0.0:
        return ()
    mass = 1.0 + accel
    roots = np.roots([accel, mass * gains.kd, mass * gains.kp, mass * gains.ki])
    real = sorted(float(root.real) for root in roots if abs(root.imag) <= REAL * np.max(np.abs(roots), axis=0))
    found = []
    for root in real:
        p = mass * gains.kd / accel + root
        product = mass * gains.kp / accel + root * p
        if p > 0.0 and product >= 0.0:
            found.append(Vertical(accel, -root * accel, product / p, p))
    if present is None or present.accel <= 0.0:
        return tuple(found)
    return tuple(sorted(found, key=lambda loop: abs(loop.accel_i / loop.accel - present.accel_i / present.accel)))


def vertical_gains(loop: Vertical, t_f: float) -> Gains:
    """Return our gains with the poles of a vertical loop."""
    mass = 1.0 + loop.accel
    kp = (loop.accel * loop.p * loop.outer + loop.accel_i * loop.p) / mass
    return Gains(kp, loop.accel_i * loop.p * loop.outer / mass, (loop.accel * loop.p + loop.accel_i) / mass, t_f)


def completed(values: Mapping[str, float], dialect: Dialect) -> dict[str, float]:
    """Return all parameters, those that are not given at their default."""
    return {**defaults(dialect.table), **values}


def switched_off(actuation: Actuation, dialect: Dialect, curve: float) -> dict[str, float]:
    """Return what ArduPilot has beside what our loops carry such that it flies what ours fly; curve: of the rotors."""
    values = {
        f"ATC_RAT_{short}_{term}": 0.0 for short in SHORT.values() for term in ("D", "FF", "D_FF", "FLTE", "SMAX")
    }
    del values[YAW_FILTER]
    for short in SHORT.values():
        values |= {f"ATC_RAT_{short}_IMAX": 1.0, f"ATC_RAT_{short}_FLTT": 50.0 if short == "YAW" else 100.0}
    values |= {dialect.names[role]: 0.0 for role in OFF_ROLES}
    values |= {dialect.names["vxy_imax"]: dialect.metre * HORIZONTAL_LIMIT, dialect.names["az_imax"]: dialect.whole}
    return values | {EXPO: curve, "MOT_THST_HOVER": hover_share(actuation, curve)}


def accel_share(
    vehicle: Vehicle, actuation: Actuation, dialect: Dialect, model: float, share: float
) -> dict[str, float]:
    """Return the P gain on the measured acceleration as a share of the hover throttle per 10 m/s2; model: MOT_THST_EXPO."""
    hover = ardupilot_scales(vehicle, actuation, model).hover
    return {dialect.names["az_p"]: 0.1 * share * hover / dialect.acceleration}


def units(values: Mapping[str, float], vehicle: Vehicle, actuation: Actuation) -> dict[str, float]:
    """Return what one unit of the inner P makes of a rate or speed, in ours [1/s], by axis but z; values: complete."""
    scales = ardupilot_scales(vehicle, actuation, values[EXPO])
    found = {
        axis: torque / inertia
        for axis, inertia, torque in zip(ATTITUDE_AXES, vehicle.inertia, scales.torque, strict=True)
    }
    return found | {"x": scales.horizontal}


def added_inertia(
    values: Mapping[str, float], vehicle: Vehicle, actuation: Actuation, dialect: Dialect
) -> dict[str, float]:
    """Return the share of inertia or mass that the gain on the acceleration adds, by axis but z [1]; values: complete."""
    return {axis: values[names(dialect)[axis][3]] * unit for axis, unit in units(values, vehicle, actuation).items()}


def factors(
    values: Mapping[str, float], vehicle: Vehicle, actuation: Actuation, dialect: Dialect, counted: bool
) -> dict[str, float]:
    """Return by axis how many times heavier ArduPilot's loop has it than ours: 1, or with the added inertia where that counts."""
    return {axis: 1.0 + counted * share for axis, share in added_inertia(values, vehicle, actuation, dialect).items()}


def names(dialect: Dialect) -> dict[str, tuple[str, str, str, str]]:
    """Return axis of ours but z -> names of the outer P, the inner P and I, and D of the inner loop."""
    found = {
        axis: (f"ATC_ANG_{short}_P", f"ATC_RAT_{short}_P", f"ATC_RAT_{short}_I", f"ATC_RAT_{short}_D")
        for axis, short in SHORT.items()
    }
    outer, p, i, d = (dialect.names[role] for role in ("xy_p", "vxy_p", "vxy_i", "vxy_d"))
    return found | {"x": (outer, p, i, d)}


def carried_names(dialect: Dialect) -> frozenset[str]:
    """Return the parameters that our loops carry; the P gain on the acceleration is free, and so not among them."""
    cascades = {name for entries in names(dialect).values() for name in entries[:3]}
    return frozenset(cascades | {dialect.names[role] for role in ("z_p", "vz_p", "az_i")} | {TILT, YAW_FILTER})


def ardupilot_loops(
    values: Mapping[str, float], vehicle: Vehicle, actuation: Actuation, dialect: Dialect
) -> dict[str, RateLoop]:
    """Return ArduPilot's loops by axis but z in our units; values: complete."""
    named = names(dialect)
    return {
        axis: RateLoop(values[named[axis][0]], unit * values[named[axis][1]], unit * values[named[axis][2]])
        for axis, unit in units(values, vehicle, actuation).items()
    }


def to_ardupilot(
    controller: Controller,
    actuation: Actuation,
    dialect: Dialect,
    beside: Mapping[str, float],
    present: Mapping[str, float] | None = None,
    counted: bool = False,
) -> dict[str, float]:
    """Return the parameters that our loops carry in ArduPilot's units, unrounded; PSC_ANGLE_MAX is missing where the vehicle's
    other limit is ours.

    beside: complete, what they act with. present: what is on the vehicle. counted: gains on acceleration count as inertia.
    Raises InputError where the gains have no such form.
    """
    vehicle = controller.airframe.vehicle
    theirs = {} if present is None else ardupilot_loops(completed(present, dialect), vehicle, actuation, dialect)
    heavier, values = factors(beside, vehicle, actuation, dialect, counted), dict[str, float]()
    for axis, unit in units(beside, vehicle, actuation).items():
        loop = rate_loop(weighted(axis_gains(controller, axis), heavier[axis]), axis, theirs.get(axis))
        values |= dict(zip(names(dialect)[axis], (loop.outer, loop.p / unit, loop.i / unit), strict=False))
    values |= _vertical(controller, actuation, dialect, beside, present)
    values[YAW_FILTER] = written_cutoff(controller, (present or {}).get(YAW_FILTER))
    return values | _tilt(controller.options.tilt_limit, present, dialect)


def _vertical(
    controller: Controller,
    actuation: Actuation,
    dialect: Dialect,
    beside: Mapping[str, float],
    present: Mapping[str, float] | None,
) -> dict[str, float]:
    """Return the vertical loop; of several forms the one nearest to the vehicle's, or that fits its ranges best."""
    vehicle = controller.airframe.vehicle
    scales = ardupilot_scales(vehicle, actuation, beside[EXPO])
    theirs = None
    if present is not None:
        before = completed(present, dialect)
        theirs = held_vertical(before, ardupilot_scales(vehicle, actuation, before[EXPO]), dialect)
    scale = dialect.acceleration * scales.climb
    accel = scale * beside[dialect.names["az_p"]]
    candidates = [
        {dialect.names["z_p"]: loop.outer, dialect.names["vz_p"]: loop.p, dialect.names["az_i"]: loop.accel_i / scale}
        for loop in vertical_loops(axis_gains(controller, "z"), accel, theirs)
    ]
    if not candidates:
        raise InputError(
            f"kp, ki and kd of z have no form as position, velocity and acceleration loop with K = {accel:.3g}; allowed: a kd "
            "that damps more, or another --set accel_gain",
            key="z.kd",
        )
    return candidates[0] if theirs else min(candidates, key=lambda found: misfit(dialect.table, found))


def _tilt(limit: float, present: Mapping[str, float] | None, dialect: Dialect) -> dict[str, float]:
    """Return PSC_ANGLE_MAX [deg]: as it is on the vehicle where our limit [rad] is what we hold of the vehicle's."""
    if present is not None and abs(held_tilt(tilt_limit(present, dialect)[0]) - limit) <= SAME * limit:
        return {TILT: present[TILT]} if TILT in present else {}
    return {TILT: degrees(limit)}


def held_vertical(values: Mapping[str, float], scales: ArdupilotScales, dialect: Dialect) -> Vertical:
    """Return the vertical loop of parameters."""
    scale = dialect.acceleration * scales.climb
    accel, accel_i, outer, p = (values[dialect.names[role]] for role in ("az_p", "az_i", "z_p", "vz_p"))
    return Vertical(scale * accel, scale * accel_i, outer, p)


def from_ardupilot(
    values: Mapping[str, float],
    vehicle: Vehicle,
    actuation: Actuation,
    dialect: Dialect,
    filters: Mapping[str, float],
    counted: bool = False,
) -> dict[str, Gains]:
    """Return our gains for parameters of ArduPilot; values: complete; filters: t_f by axis [s]; counted: D counts as inertia,
    else it does not enter.
    """
    heavier = factors(values, vehicle, actuation, dialect, counted)
    gains = {
        axis: weighted(parallel(loop, filters[axis]), 1.0 / heavier[axis])
        for axis, loop in ardupilot_loops(values, vehicle, actuation, dialect).items()
    }
    vertical = held_vertical(values, ardupilot_scales(vehicle, actuation, values[EXPO]), dialect)
    return gains | {"y": gains["x"]._replace(t_f=filters["y"]), "z": vertical_gains(vertical, filters["z"])}


def tilt_limit(values: Mapping[str, float], dialect: Dialect) -> tuple[float, str]:
    """Return the largest tilt [rad] and the parameter that it comes from: PSC_ANGLE_MAX, or the lean angle where that is 0."""
    if values.get(TILT, 0.0) > 0.0:
        return radians(values[TILT]), TILT
    name, unit, usual = LEAN[dialect.firmware]
    return radians(unit * values.get(name, usual)), name
