"""PX4: a parameter file of QGroundControl as a PID controller of ours, on an airframe that the file does not describe."""

from collections.abc import Mapping

from plant.input_files import ReadableFile
from plant.quadrotor.airframes import Airframe
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.cascade import ATTITUDE_AXES
from tuner.exchange.aboard import DERIVATIVE
from tuner.exchange.target import ImportedController, Importer, number
from tuner.extensions.autopilots.assembly import (
    ATTITUDE_FILTER,
    CURVE,
    LOOPS,
    POSITION_EVERY,
    POSITION_FILTER,
    absent_note,
    control_period,
    curve,
    settings_note,
    unused_note,
    version_note,
)
from tuner.extensions.autopilots.cascade import ParameterFile, cascade_for, imported
from tuner.extensions.autopilots.parameters import Values, defaults, stated
from tuner.extensions.autopilots.resolution import plain_file
from tuner.extensions.autopilots.sources import major_minor
from tuner.extensions.px4.map import AROUND, HOVER, LOOP_RATE, PX4, TABLE, YAW_FILTER, Px4
from tuner.extensions.px4.other_files import resolved
from tuner.extensions.px4.text import VERSION, WHAT, read_params
from tuner.gains.ranges import LONGEST, SHORTEST
from tuner.text.sentences import SAME

# Weights of yaw up to this are none, AttitudeControl.cpp.
MIN_WEIGHT = 1e-4
FIRST_WITH_YAW_FILTER = (1, 16)
"""First version whose yaw torque has a low-pass."""


def read(file: ReadableFile, airframe: Airframe, settings: Mapping[str, str]) -> ImportedController:
    """Return the controller of a file; raises InputError naming file and parameter."""
    other = resolved(file)
    file = plain_file(file, other)
    version = stated(file, WHAT).version
    given = read_params(file)
    early = {} if YAW_FILTER in given else filters_off(version)
    given |= early
    cascade = cascade_for(PX4, settings)
    px4 = Px4(PX4.flying(cascade), airframe.vehicle, actuation(airframe.vehicle, curve(settings)))
    values = px4.completed(given)
    usual = {name: value for name, value in defaults(TABLE).items() if name != HOVER}
    feed = tuple(f"MC_{axis.upper()}RATE_FF" for axis in ATTITUDE_AXES)
    notes = (
        *(() if other is None else other.notes),
        f"Read as {PX4.name}, with the rotors of the airframe {airframe.name} in its CA_ROTORi_*.",
        *version_note(version, PX4.name, (VERSION,)),
        *settings_note("The version of the file lacks these filters, which are off", dict.fromkeys(early, "0")),
        *_period(given, number(settings, "control_period", SHORTEST, LONGEST, "s")),
        *absent_note(given, usual, PX4.name),
        *_scaled(values),
    )
    later_notes = (
        *unused_note(values, feed, "Feed-forward of the rate setpoint, which holds the angle error too, is left out"),
        *_weight(values["MC_YAW_WEIGHT"]),
        *_hover(given),
    )
    described = ParameterFile(file, given, PX4.name, (*TABLE, *AROUND), notes, later_notes, LOOP_RATE in given)
    return imported(px4, described, airframe, cascade, settings, values)


def filters_off(version: str | None) -> dict[str, float]:
    """Return the filters that a version of PX4 lacks, off.

    The low-pass of the yaw torque came in January 2025 (PX4 pull request 24173), with 1.16.
    """
    number = major_minor(version)
    is_early = number is not None and tuple(map(int, number.split("."))) < FIRST_WITH_YAW_FILTER
    return {YAW_FILTER: 0.0} if is_early else {}


def _period(given: Values, period: float) -> tuple[str, ...]:
    """Return a sentence where rate and control period [s] differ."""
    rate = given.get(LOOP_RATE, 0.0)
    if rate <= 0.0 or abs(rate * period - 1.0) <= SAME:
        return ()
    return (
        f"{LOOP_RATE} = {rate:g}: import with --set control_period={1.0 / rate:.10g}; the loops are read at {period:g} s.",
    )


def _scaled(values: Values) -> tuple[str, ...]:
    names = tuple(f"MC_{axis.upper()}RATE_K" for axis in ATTITUDE_AXES)
    factors = [f"{name} = {values[name]:g}" for name in names if values[name] != 1.0]
    return (f"P and I of the rate loops are multiplied by {', '.join(factors)}.",) if factors else ()


def _weight(weight: float) -> tuple[str, ...]:
    """Return a sentence on a yaw weight of 0: AttitudeControl.cpp divides the gain by any other weight."""
    if weight > MIN_WEIGHT:
        return ()
    return (f"MC_YAW_WEIGHT = {weight:g} takes the heading out of the vehicle's angle loop; ours holds it.",)


def _hover(given: Values) -> tuple[str, ...]:
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
    name=PX4.target,
    title=f"{PX4.name}, parameter file of QGroundControl",
    options=(control_period("0.0025"), LOOPS, POSITION_EVERY, CURVE, ATTITUDE_FILTER, POSITION_FILTER, DERIVATIVE),
    read=read,
)
