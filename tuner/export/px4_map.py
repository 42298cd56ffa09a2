"""Our PID as the parameters of PX4's cascade, and back.

PX4 has an angle loop P around a rate loop PI in normalised torque, and a position loop P around a velocity loop PI in m/s2. Its
acceleration becomes tilt and thrust with g = 9.80665 m/s2 and the hover thrust; what the vehicle then does differs by the local
gravity, and along z by how thrust follows the command.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import degrees, radians

from plant.airframes.actuation import Actuation
from plant.cascade import ATTITUDE_AXES
from plant.laws.pid import Gains
from plant.vehicle import Vehicle
from tuner.export.autopilot_pid import axis_gains
from tuner.export.autopilot_scales import TorqueScale, command_slope, hover_share, px4_factors, torque_scale
from tuner.export.pid_cascade import RateLoop, parallel, rate_loop
from tuner.gains_file import Controller

GRAVITY = 9.80665
TARGET = "PX4"
LIMITS = {"roll": "MC_RR_INT_LIM", "pitch": "MC_PR_INT_LIM", "yaw": "MC_YR_INT_LIM"}
HORIZONTAL = ("x", "y")


@dataclass(frozen=True)
class Px4Scales:
    """torque for one unit [N m]; horizontal, vertical: what the vehicle accelerates by for 1 m/s2 of PX4's [1]; hover: command at
    hover [1].
    """

    torque: TorqueScale
    horizontal: float
    vertical: float
    hover: float


def px4_scales(vehicle: Vehicle, actuation: Actuation, model: float, hover: float | None = None) -> Px4Scales:
    """Work out the scales; model: THR_MDL_FAC; hover: what PX4 takes for the hover command, by default what it is."""
    slope, truth = command_slope(actuation, model), hover_share(actuation, model)
    taken = truth if hover is None else hover
    horizontal = vehicle.gravity / GRAVITY
    vertical = horizontal * slope * taken / actuation.hover_thrust
    torque = torque_scale(actuation, px4_factors(actuation), slope, TARGET)
    return Px4Scales(torque, horizontal, vertical, taken)


def loops(controller: Controller) -> dict[str, RateLoop]:
    """Return the cascaded form of every axis, x for both horizontal ones."""
    return {axis: rate_loop(axis_gains(controller, axis), axis) for axis in ("x", "z", *ATTITUDE_AXES)}


def to_px4(controller: Controller, actuation: Actuation, model: float) -> dict[str, float]:
    """Return the parameters in PX4's units, unrounded."""
    vehicle = controller.airframe.vehicle
    scales = px4_scales(vehicle, actuation, model)
    cascade = loops(controller)
    values: dict[str, float] = {}
    for axis, inertia, torque in zip(ATTITUDE_AXES, vehicle.inertia, scales.torque, strict=True):
        name, loop = f"MC_{axis.upper()}RATE", cascade[axis]
        values |= {
            f"MC_{axis.upper()}_P": loop.outer,
            f"{name}_P": inertia * loop.p / torque,
            f"{name}_I": inertia * loop.i / torque,
            f"{name}_D": 0.0,
            f"{name}_FF": 0.0,
            f"{name}_K": 1.0,
            LIMITS[axis]: 1.0,
        }
    for axis, name, scale in (("x", "XY", scales.horizontal), ("z", "Z", scales.vertical)):
        loop = cascade[axis]
        values |= {
            f"MPC_{name}_P": loop.outer,
            f"MPC_{name}_VEL_P_ACC": loop.p / scale,
            f"MPC_{name}_VEL_I_ACC": loop.i / scale,
            f"MPC_{name}_VEL_D_ACC": 0.0,
        }
    return values | {
        "MC_YAW_WEIGHT": 1.0,
        "MC_YAW_TQ_CUTOFF": 0.0,
        "MPC_THR_HOVER": scales.hover,
        "MPC_TILTMAX_AIR": degrees(controller.options.tilt_limit),
        "THR_MDL_FAC": model,
    }


def from_px4(
    values: Mapping[str, float],
    vehicle: Vehicle,
    actuation: Actuation,
    filters: Mapping[str, float],
    fixed_hover: bool = True,
) -> dict[str, Gains]:
    """Return our gains for parameters of PX4; filters: t_f by axis [s]; fixed_hover: MPC_THR_HOVER counts, not an estimate of it.

    K scales P, I and D of the rate loops. D has no counterpart in our law and does not enter.
    """
    hover = values["MPC_THR_HOVER"] if fixed_hover else None
    scales = px4_scales(vehicle, actuation, values["THR_MDL_FAC"], hover)
    gains: dict[str, Gains] = {}
    for axis, inertia, torque in zip(ATTITUDE_AXES, vehicle.inertia, scales.torque, strict=True):
        name = f"MC_{axis.upper()}RATE"
        scale = values[f"{name}_K"] * torque / inertia
        loop = RateLoop(values[f"MC_{axis.upper()}_P"], scale * values[f"{name}_P"], scale * values[f"{name}_I"])
        gains[axis] = parallel(loop, filters[axis])
    for axis, name, scale in (
        ("x", "XY", scales.horizontal),
        ("y", "XY", scales.horizontal),
        ("z", "Z", scales.vertical),
    ):
        velocity = f"MPC_{name}_VEL"
        loop = RateLoop(
            values[f"MPC_{name}_P"], scale * values[f"{velocity}_P_ACC"], scale * values[f"{velocity}_I_ACC"]
        )
        gains[axis] = parallel(loop, filters[axis])
    return gains


def tilt_limit(values: Mapping[str, float]) -> float:
    """Return the largest tilt [rad]."""
    return radians(values["MPC_TILTMAX_AIR"])
