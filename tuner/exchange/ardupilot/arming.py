"""What ArduPilot's pre-arm checks ask of parameters alone: a vehicle that breaks one loads the file and then refuses to arm.

AC_PosControl::pre_arm_checks, AC_AttitudeControl::pre_arm_checks and AP_Arming_Copter::parameter_checks of 4.6 and 4.7.
"""

from collections.abc import Mapping

from plant.errors import InputError
from tuner.exchange.ardupilot.ranges import Dialect

# What counts as above 0 there: FLT_EPSILON of is_positive.
SMALLEST = 1.1920929e-7
POSITIVE_ROLES = ("xy_p", "z_p", "vz_p", "az_p", "az_i")
SHORTS = ("RLL", "PIT", "YAW")
BALANCE = {"ACRO_BAL_ROLL": "ATC_ANG_RLL_P", "ACRO_BAL_PITCH": "ATC_ANG_PIT_P"}


def check_arming(values: Mapping[str, float], dialect: Dialect) -> None:
    """Refuse parameters with which a vehicle does not arm; values: what it has with the file; raises InputError naming one."""
    for name in positive_names(values, dialect):
        if name in values and not values[name] >= SMALLEST:
            raise InputError(
                f"works out at {values[name] + 0.0:g}; Copter {dialect.firmware} does not arm unless it is above 0: "
                f"change {dialect.table[name].source}",
                key=name,
            )
    for balance, gain in BALANCE.items():
        if balance in values and gain in values and values[balance] > values[gain]:
            raise InputError(
                f"works out at {values[gain]:g} 1/s; Copter {dialect.firmware} does not arm with {balance} = "
                f"{values[balance]:g} above it: tune a faster angle loop, or lower {balance} on the vehicle",
                key=gain,
            )


def positive_names(values: Mapping[str, float], dialect: Dialect) -> list[str]:
    """Return what must be above 0; P and I of a rate loop may be 0 where it has feed-forward."""
    names = [dialect.names[role] for role in POSITIVE_ROLES] + [f"ATC_ANG_{short}_P" for short in SHORTS]
    for short in SHORTS:
        if not values.get(f"ATC_RAT_{short}_FF", 0.0) >= SMALLEST:
            names += [f"ATC_RAT_{short}_P", f"ATC_RAT_{short}_I"]
    return names
