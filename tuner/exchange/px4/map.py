"""Our PID as the parameters of PX4's cascade, and back.

PX4 has an angle loop P around a rate loop PI in normalised torque, and a position loop P around a velocity loop PI in m/s2. Its
acceleration becomes tilt and thrust with g = 9.80665 m/s2 and the hover thrust; what the vehicle then does differs by the local
gravity, and along z by how thrust follows the command.

Our loops carry the parameters of `CARRIED`. The others scale them (K, thrust model, hover thrust) or act beside them; on a
vehicle that is known they stay as they are, and otherwise are chosen so that PX4 flies what ours fly.

Parameters of PX4 1.16 that an export writes: units, ranges, defaults.

PX4/PX4-Autopilot, release 1.16: src/modules/mc_rate_control/mc_rate_control_params.c, mc_att_control/mc_att_control_params.c,
mc_pos_control/multicopter_position_control_{gain,}_params.c and ..._limits_params.c, src/lib/mixer_module/params.c. PX4 documents
these ranges and does not enforce them.

MPC_XY_VEL_D_ACC is documented from 0.1 on; 0 stands here, for it switches a term off that our law does not have, and the source
(PositionControl.cpp) takes it as any other number.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import degrees, radians

from plant.airframes.actuation import Actuation
from plant.cascade import ATTITUDE_AXES
from plant.laws.pid import Gains
from plant.vehicle import Vehicle
from tuner.exchange.autopilot.parameters import Entry, defaults, unbounded
from tuner.exchange.autopilot.pid import (
    SAME,
    RateLoop,
    axis_gains,
    held_tilt,
    parallel,
    rate_loop,
    weighted,
    written_cutoff,
)
from tuner.exchange.autopilot.scales import TorqueScale, command_slope, hover_share, px4_factors, torque_scale
from tuner.gains import Controller

TORQUE = "normalised torque"
# What acts in or around these loops and is never written: an import names it where a file has it.
AROUND = (
    "MPC_USE_HTE", "MPC_THR_MIN", "MPC_THR_MAX", "MPC_THR_XY_MARG", "MPC_XY_VEL_MAX", "MPC_Z_VEL_MAX_UP", "MPC_Z_VEL_MAX_DN",
    "MPC_ACC_HOR", "MPC_ACC_HOR_MAX", "MPC_ACC_UP_MAX", "MPC_ACC_DOWN_MAX", "MPC_JERK_AUTO", "MPC_JERK_MAX", "MPC_VEL_LP",
    "MPC_VEL_NF_FRQ", "MPC_VEL_NF_BW", "MPC_VELD_LP", "MC_ROLLRATE_MAX", "MC_PITCHRATE_MAX", "MC_YAWRATE_MAX", "MC_AIRMODE",
    "MC_BAT_SCALE_EN", "IMU_GYRO_CUTOFF", "IMU_DGYRO_CUTOFF", "IMU_GYRO_RATEMAX", "IMU_GYRO_NF0_FRQ", "IMU_GYRO_NF0_BW",
    "IMU_GYRO_NF1_FRQ", "IMU_GYRO_NF1_BW", "IMU_GYRO_DNF_EN", "CA_METHOD",
)  # fmt: skip


def _rate(
    axis: str, ours: str, limit: str, p: tuple[float, float, float], i: float, d: tuple[float, float]
) -> list[Entry]:
    """Return one rate loop; p: low, high, default; i: default; d: high, default."""
    name = f"MC_{axis}RATE"
    off = "nothing: it is switched off"
    return [
        Entry(f"{name}_P", f"{TORQUE} per rad/s", *p, f"{ours}.kd"),
        unbounded(f"{name}_I", f"{TORQUE} per rad", 0.0, i, f"{ours}.ki"),
        Entry(f"{name}_D", f"{TORQUE} per rad/s2", 0.0, *d, off),
        unbounded(f"{name}_FF", f"{TORQUE} per rad/s", 0.0, 0.0, off),
        Entry(f"{name}_K", "1", 0.01, 5.0, 1.0, "nothing: it is 1"),
        unbounded(limit, TORQUE, 0.0, 0.3, "nothing: it is the whole torque"),
    ]


TABLE = {
    entry.name: entry
    for entry in (
        *_rate("ROLL", "roll", "MC_RR_INT_LIM", (0.01, 0.5, 0.15), 0.2, (0.01, 0.003)),
        *_rate("PITCH", "pitch", "MC_PR_INT_LIM", (0.01, 0.6, 0.15), 0.2, (1.0, 0.003)),
        *_rate("YAW", "yaw", "MC_YR_INT_LIM", (0.0, 0.6, 0.2), 0.1, (1.0, 0.0)),
        Entry("MC_ROLL_P", "1/s", 0.0, 12.0, 4.0, "roll.kp, roll.ki or roll.kd"),
        Entry("MC_PITCH_P", "1/s", 0.0, 12.0, 4.0, "pitch.kp, pitch.ki or pitch.kd"),
        Entry("MC_YAW_P", "1/s", 0.0, 5.0, 2.8, "yaw.kp, yaw.ki or yaw.kd"),
        Entry("MC_YAW_WEIGHT", "1", 0.0, 1.0, 0.4, "nothing: it is 1"),
        Entry("MC_YAW_TQ_CUTOFF", "Hz", 0.0, 10.0, 2.0, "controller.yaw_torque_cutoff"),
        Entry("MPC_XY_P", "1/s", 0.0, 2.0, 0.95, "x.kp, x.ki or x.kd"),
        Entry("MPC_XY_VEL_P_ACC", "1/s", 1.2, 5.0, 1.8, "x.kd"),
        Entry("MPC_XY_VEL_I_ACC", "1/s2", 0.0, 60.0, 0.4, "x.ki"),
        Entry("MPC_XY_VEL_D_ACC", "1", 0.0, 2.0, 0.2, "nothing: it is switched off"),
        Entry("MPC_Z_P", "1/s", 0.1, 1.5, 1.0, "z.kp, z.ki or z.kd"),
        Entry("MPC_Z_VEL_P_ACC", "1/s", 2.0, 15.0, 4.0, "z.kd"),
        Entry("MPC_Z_VEL_I_ACC", "1/s2", 0.2, 3.0, 2.0, "z.ki"),
        Entry("MPC_Z_VEL_D_ACC", "1", 0.0, 2.0, 0.0, "nothing: it is switched off"),
        Entry("MPC_THR_HOVER", "1", 0.1, 0.8, 0.5, "the airframe or --set thrust_curve"),
        Entry("MPC_TILTMAX_AIR", "deg", 20.0, 89.0, 45.0, "controller.tilt_limit"),
        Entry("THR_MDL_FAC", "1", 0.0, 1.0, 0.0, "--set thrust_curve"),
    )
}


GRAVITY = 9.80665
NAME = "PX4"
LIMITS = {"roll": "MC_RR_INT_LIM", "pitch": "MC_PR_INT_LIM", "yaw": "MC_YR_INT_LIM"}
HOVER, MODEL, TILT = "MPC_THR_HOVER", "THR_MDL_FAC", "MPC_TILTMAX_AIR"
# The same filter as ours, alpha = h/(h + tau).
YAW_FILTER = "MC_YAW_TQ_CUTOFF"
# Axis of ours -> names of the outer P, the inner P and I, and D of the inner loop; y goes with x.
NAMES = {
    **{
        axis: (f"MC_{axis.upper()}_P", *(f"MC_{axis.upper()}RATE_{term}" for term in "PID")) for axis in ATTITUDE_AXES
    },
    **{
        axis: (f"MPC_{name}_P", *(f"MPC_{name}_VEL_{term}_ACC" for term in "PID"))
        for axis, name in (("x", "XY"), ("z", "Z"))
    },
}  # fmt: skip
CARRIED = frozenset({name for names in NAMES.values() for name in names[:3]} | {TILT, YAW_FILTER})


@dataclass(frozen=True)
class Px4Scales:
    """torque for one unit [N m]; horizontal, vertical: what the vehicle accelerates by for 1 m/s2 of PX4's [1]."""

    torque: TorqueScale
    horizontal: float
    vertical: float


def px4_scales(vehicle: Vehicle, actuation: Actuation, model: float, hover: float) -> Px4Scales:
    """Work out the scales; model: THR_MDL_FAC; hover: MPC_THR_HOVER."""
    slope = command_slope(actuation, model)
    horizontal = vehicle.gravity / GRAVITY
    vertical = horizontal * slope * hover / actuation.hover_thrust
    return Px4Scales(torque_scale(actuation, px4_factors(actuation), slope, NAME), horizontal, vertical)


def completed(values: Mapping[str, float], actuation: Actuation) -> dict[str, float]:
    """Return all parameters, those that are not given at their default; the hover thrust is then what it is."""
    full = {**defaults(TABLE), **values}
    return full if HOVER in values else full | {HOVER: hover_share(actuation, full[MODEL])}


def switched_off(actuation: Actuation, model: float) -> dict[str, float]:
    """Return what PX4 has beside what our loops carry such that it flies what ours fly; model: THR_MDL_FAC."""
    rates = {f"MC_{axis.upper()}RATE_{term}": float(term == "K") for axis in ATTITUDE_AXES for term in ("D", "FF", "K")}
    velocities = {"MPC_XY_VEL_D_ACC": 0.0, "MPC_Z_VEL_D_ACC": 0.0}
    yaw = {"MC_YAW_WEIGHT": 1.0}
    thrust = {MODEL: model, HOVER: hover_share(actuation, model)}
    return rates | dict.fromkeys(LIMITS.values(), 1.0) | velocities | yaw | thrust


def units(values: Mapping[str, float], vehicle: Vehicle, actuation: Actuation) -> dict[str, float]:
    """Return what one unit of PX4's inner P makes of a rate or speed, in ours [1/s], by axis; values: complete."""
    scales = px4_scales(vehicle, actuation, values[MODEL], values[HOVER])
    found = {
        axis: values[f"MC_{axis.upper()}RATE_K"] * torque / inertia
        for axis, inertia, torque in zip(ATTITUDE_AXES, vehicle.inertia, scales.torque, strict=True)
    }
    return found | {"x": scales.horizontal, "z": scales.vertical}


def added_inertia(values: Mapping[str, float], vehicle: Vehicle, actuation: Actuation) -> dict[str, float]:
    """Return the share of inertia or mass that the gain on the measured acceleration adds, by axis [1]; values: complete."""
    return {axis: values[NAMES[axis][3]] * unit for axis, unit in units(values, vehicle, actuation).items()}


def factors(values: Mapping[str, float], vehicle: Vehicle, actuation: Actuation, counted: bool) -> dict[str, float]:
    """Return by axis how many times heavier PX4's loop has it than ours: 1, or with the added inertia where that counts."""
    return {axis: 1.0 + counted * share for axis, share in added_inertia(values, vehicle, actuation).items()}


def px4_loops(values: Mapping[str, float], vehicle: Vehicle, actuation: Actuation) -> dict[str, RateLoop]:
    """Return PX4's loops by axis in our units; values: complete."""
    return {
        axis: RateLoop(values[NAMES[axis][0]], unit * values[NAMES[axis][1]], unit * values[NAMES[axis][2]])
        for axis, unit in units(values, vehicle, actuation).items()
    }


def loops(
    controller: Controller, present: Mapping[str, RateLoop], factor: Mapping[str, float] | None = None
) -> dict[str, RateLoop]:
    """Return the cascaded form of every axis, x for both horizontal ones; present: loops on the vehicle or {}; factor: see
    `factors`.
    """
    heavier = factor or {}
    return {
        axis: rate_loop(weighted(axis_gains(controller, axis), heavier.get(axis, 1.0)), axis, present.get(axis))
        for axis in NAMES
    }


def to_px4(
    controller: Controller,
    actuation: Actuation,
    beside: Mapping[str, float],
    present: Mapping[str, float] | None = None,
    counted: bool = False,
) -> dict[str, float]:
    """Return the parameters of `CARRIED` in PX4's units, unrounded.

    beside: complete, what they act with. present: what is on the vehicle. counted: gains on acceleration count as inertia.
    """
    vehicle = controller.airframe.vehicle
    theirs = {} if present is None else px4_loops(completed(present, actuation), vehicle, actuation)
    cascade = loops(controller, theirs, factors(beside, vehicle, actuation, counted))
    values: dict[str, float] = {}
    for axis, unit in units(beside, vehicle, actuation).items():
        loop = cascade[axis]
        values |= dict(zip(NAMES[axis], (loop.outer, loop.p / unit, loop.i / unit), strict=False))
    aboard = present or {}
    yaw = written_cutoff(controller, aboard.get(YAW_FILTER))
    return values | {TILT: _tilt(controller.options.tilt_limit, aboard.get(TILT)), YAW_FILTER: yaw}


def _tilt(limit: float, present: float | None) -> float:
    """Return the largest tilt [deg]; that of the vehicle where ours [rad] is what we hold of it."""
    if present is not None and abs(held_tilt(radians(present)) - limit) <= SAME * limit:
        return present
    return degrees(limit)


def from_px4(
    values: Mapping[str, float],
    vehicle: Vehicle,
    actuation: Actuation,
    filters: Mapping[str, float],
    counted: bool = False,
) -> dict[str, Gains]:
    """Return our gains for parameters of PX4; values: complete; filters: t_f by axis [s]; counted: D counts as inertia, else it
    does not enter.
    """
    heavier = factors(values, vehicle, actuation, counted)
    gains = {
        axis: weighted(parallel(loop, filters[axis]), 1.0 / heavier[axis])
        for axis, loop in px4_loops(values, vehicle, actuation).items()
    }
    return gains | {"y": gains["x"]._replace(t_f=filters["y"])}


def tilt_limit(values: Mapping[str, float]) -> float:
    """Return the largest tilt [rad]."""
    return radians(values[TILT])
