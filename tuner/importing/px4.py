"""PX4: a parameter file of QGroundControl as a PID controller of ours, on an airframe that the file does not describe."""

from collections.abc import Mapping
from pathlib import Path

from plant.airframes import Airframe
from plant.airframes.actuation import actuation
from plant.cascade import ATTITUDE_AXES
from tuner.export.parameter_table import defaults
from tuner.export.px4_map import from_px4, px4_scales, tilt_limit
from tuner.export.px4_ranges import TABLE
from tuner.export.px4_text import VERSION, read_params
from tuner.importing.assembly import (
    ATTITUDE_FILTER,
    CURVE,
    DERIVATIVE,
    POSITION_FILTER,
    absent_note,
    assumed_note,
    control_period,
    controller,
    curve,
    filters,
    inertia_note,
    lightened,
    tilt_note,
    unused_note,
)
from tuner.importing.importer import Imported, Importer

NAME = f"PX4 {VERSION}"
# What the loops read beside what an export writes.
EXTRA = {"MPC_USE_HTE": 1.0}
HORIZONTAL, VERTICAL = "MPC_XY_VEL_D_ACC", "MPC_Z_VEL_D_ACC"


def read(file: Path, airframe: Airframe, settings: Mapping[str, str]) -> Imported:
    """Return the controller of a file; raises InputError naming file and parameter."""
    given = read_params(file)
    usual = defaults(TABLE) | EXTRA
    values = usual | given
    rotors = actuation(airframe.vehicle, curve(settings))
    fixed = "MPC_THR_HOVER" in given
    gains = from_px4(values, airframe.vehicle, rotors, filters(settings), fixed)
    shares = added_inertia(values, airframe, settings)
    if settings[DERIVATIVE.name] == "inertia":
        names = {axis: f"MC_{axis.upper()}RATE_D" for axis in ATTITUDE_AXES}
        names |= {"x": HORIZONTAL, "y": HORIZONTAL, "z": VERTICAL}
        gains = {axis: lightened(loop, shares[names[axis]]) for axis, loop in gains.items()}
    tilt = tilt_limit(values)
    feed = tuple(f"MC_{axis.upper()}RATE_FF" for axis in ATTITUDE_AXES)
    notes = (
        f"Read as {NAME}, with the rotors of the airframe {airframe.name} in its CA_ROTORi_*.",
        *absent_note(given, {name: usual[name] for name in TABLE if name != "MPC_THR_HOVER"}, NAME),
        *_scaled(values),
        *inertia_note(shares, settings[DERIVATIVE.name] == "inertia"),
        *unused_note(values, feed, "Feed-forward of the rate setpoint, which holds the angle error too, is left out"),
        *unused_note(values, ("MC_YAW_TQ_CUTOFF",), "The low-pass of the yaw torque [Hz] is left out"),
        *_hover(fixed, values),
        *tilt_note(tilt, "MPC_TILTMAX_AIR"),
    )
    return Imported(controller(file, airframe, gains, tilt, settings), (*notes, assumed_note(settings)))


def added_inertia(values: Mapping[str, float], airframe: Airframe, settings: Mapping[str, str]) -> dict[str, float]:
    """Return parameter -> share of inertia or mass that its gain on the measured acceleration adds [1]."""
    vehicle = airframe.vehicle
    scales = px4_scales(vehicle, actuation(vehicle, curve(settings)), values["THR_MDL_FAC"])
    shares: dict[str, float] = {}
    for axis, inertia, torque in zip(ATTITUDE_AXES, vehicle.inertia, scales.torque, strict=True):
        name = f"MC_{axis.upper()}RATE"
        shares[f"{name}_D"] = values[f"{name}_K"] * values[f"{name}_D"] * torque / inertia
    return shares | {HORIZONTAL: values[HORIZONTAL] * scales.horizontal, VERTICAL: values[VERTICAL] * scales.vertical}


def _scaled(values: Mapping[str, float]) -> tuple[str, ...]:
    names = tuple(f"MC_{axis.upper()}RATE_K" for axis in ATTITUDE_AXES)
    there = [f"{name} = {values[name]:g}" for name in names if values[name] != 1.0]
    return (f"P and I of the rate loops are multiplied by {', '.join(there)}.",) if there else ()


def _hover(fixed: bool, values: Mapping[str, float]) -> tuple[str, ...]:
    if not fixed:
        return (
            "MPC_THR_HOVER is not in the file: the vertical gains are taken with the airframe's own hover command.",
        )
    if values["MPC_USE_HTE"] != 0.0:
        return (
            "MPC_USE_HTE replaces MPC_THR_HOVER in flight by an estimate; the vertical gains are taken with MPC_THR_HOVER.",
        )
    return ()


IMPORTER = Importer(
    name="px4",
    title=f"{NAME}, parameter file of QGroundControl",
    options=(control_period("0.0025"), CURVE, ATTITUDE_FILTER, POSITION_FILTER, DERIVATIVE),
    read=read,
)
