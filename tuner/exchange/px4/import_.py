"""PX4: a parameter file of QGroundControl as a PID controller of ours, on an airframe that the file does not describe."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from plant.airframes import Airframe
from plant.airframes.actuation import actuation
from plant.cascade import ATTITUDE_AXES
from tuner.exchange.autopilot.assembly import (
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
    kept_notes,
    record_of,
    tilt_note,
    unused_note,
    version_note,
)
from tuner.exchange.autopilot.parameters import stated
from tuner.exchange.autopilot.pid import held_cutoff
from tuner.exchange.px4.map import (
    AROUND,
    CARRIED,
    HOVER,
    NAMES,
    TABLE,
    YAW_FILTER,
    added_inertia,
    completed,
    from_px4,
    tilt_limit,
)
from tuner.exchange.px4.text import VERSION, WHAT, read_params
from tuner.exchange.target import Imported, Importer

NAME = f"PX4 {VERSION}"
# Weights of yaw up to this are none, AttitudeControl.cpp.
LEAST_WEIGHT = 1e-4


def read(file: Path, airframe: Airframe, settings: Mapping[str, str]) -> Imported:
    """Return the controller of a file; raises InputError naming file and parameter."""
    given = read_params(file)
    vehicle, rotors = airframe.vehicle, actuation(airframe.vehicle, curve(settings))
    values = completed(given, rotors)
    counted = settings[DERIVATIVE.name] == "inertia"
    gains = from_px4(values, vehicle, rotors, filters(settings), counted)
    shares = {NAMES[axis][3]: share for axis, share in added_inertia(values, vehicle, rotors).items()}
    tilt = tilt_limit(values)
    feed = tuple(f"MC_{axis.upper()}RATE_FF" for axis in ATTITUDE_AXES)
    record = record_of(file, "px4", NAME, settings, given, (*TABLE, *AROUND), CARRIED)
    untouched = tuple(name for name in given if name not in record.parameters)
    notes = (
        f"Read as {NAME}, with the rotors of the airframe {airframe.name} in its CA_ROTORi_*.",
        *version_note(stated(file, WHAT).version, NAME, (VERSION,)),
        *absent_note(given, {name: value for name, value in values.items() if name != HOVER}, NAME),
        *_scaled(values),
        *inertia_note(shares, counted),
        *unused_note(values, feed, "Feed-forward of the rate setpoint, which holds the angle error too, is left out"),
        *_weight(values["MC_YAW_WEIGHT"]),
        *_hover(given),
        *tilt_note(tilt, "MPC_TILTMAX_AIR"),
        *kept_notes(record, untouched),
        assumed_note(settings),
    )
    found = controller(file, airframe, gains, tilt, settings)
    options = replace(found.options, yaw_torque_cutoff=held_cutoff(values[YAW_FILTER]))
    return Imported(replace(found, options=options, vehicle=record), notes, untouched)


def _scaled(values: Mapping[str, float]) -> tuple[str, ...]:
    names = tuple(f"MC_{axis.upper()}RATE_K" for axis in ATTITUDE_AXES)
    there = [f"{name} = {values[name]:g}" for name in names if values[name] != 1.0]
    return (f"P and I of the rate loops are multiplied by {', '.join(there)}.",) if there else ()


def _weight(weight: float) -> tuple[str, ...]:
    """AttitudeControl.cpp divides the gain of yaw by its weight again, so only a weight of 0 changes a small error."""
    if weight > LEAST_WEIGHT:
        return ()
    return (f"MC_YAW_WEIGHT = {weight:g} takes the heading out of the vehicle's angle loop; ours holds it.",)


def _hover(given: Mapping[str, float]) -> tuple[str, ...]:
    if HOVER not in given:
        return (
            "MPC_THR_HOVER is not in the file: the vertical gains are taken with the airframe's own hover command.",
        )
    if given.get("MPC_USE_HTE", 1.0) != 0.0:
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
