"""Parameters of ArduPilot Copter 4.6 and 4.7 that an export writes: units, ranges, defaults.

ArduPilot/ParameterRepository, Copter-4.6 and Copter-4.7, apm.pdef.xml (the first entry of each ATC_RAT_*, which is the one of
multicopters; the second is that of helicopters), with the defaults of AC_AttitudeControl_Multi.h and AC_PosControl.cpp. ArduPilot
documents these ranges and does not enforce them.

Ranges of I, FF and D terms that are documented from above 0 on, though 0 is their default and switches them off, start at 0 here:
PSC_VELZ_I (0.02 to 1), PSC_NE_VEL_I and PSC_NE_VEL_FF (0.1 to 10), PSC_VELXY_I (0.02 to 1).

Pre-arm checks that depend on parameters alone, for a vehicle that fails one loads the file and then refuses to arm:
AC_PosControl::pre_arm_checks, AC_AttitudeControl::pre_arm_checks and AP_Arming_Copter::parameter_checks of 4.6 and 4.7.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from plant.errors import InputError
from plant.input_files import ReadableFile
from tuner.extensions.autopilots.cascade import CascadeNames, ParameterSet
from tuner.extensions.autopilots.native_loops import NativeLaw
from tuner.extensions.autopilots.parameters import ParameterInfo, Values

TORQUE = "normalised torque"
OFF = "nothing: it is switched off"
FIRMWARES = ("4.6", "4.7")
# Options of the export.
ACCEL_GAIN, SEPARATOR = "accel_gain", "separator"
EXPO, TILT = "MOT_THST_EXPO", "PSC_ANGLE_MAX"
# Low-pass of the rate error of yaw: with neither D nor FF the same as one on the torque.
YAW_FILTER = "ATC_RAT_YAW_FLTE"
SHORT = {"roll": "RLL", "pitch": "PIT", "yaw": "YAW"}
# Roles that our vertical loop carries, and those that scale it.
VERTICAL, SCALING = ("z_p", "vz_p", "az_i"), ("az_p",)


@dataclass(frozen=True)
class Dialect(ParameterSet):
    """Parameters of a version, and the units of its position loops.

    Attributes:
        roles: Parameter by our name of its role.
        acceleration: Throttle per m/s2 for one unit of the acceleration gains.
        metre: Integral limit of 1 m/s2.
        full_scale: Integral limit of full throttle.
    """

    firmware: str
    roles: Mapping[str, str]
    acceleration: float
    metre: float
    full_scale: float

    def named(self, *roles: str) -> tuple[str, ...]:
        """Return the parameters of roles."""
        return tuple(self.roles[role] for role in roles)


NAMES_46 = {
    "xy_p": "PSC_POSXY_P", "vxy_p": "PSC_VELXY_P", "vxy_i": "PSC_VELXY_I", "vxy_d": "PSC_VELXY_D", "vxy_imax": "PSC_VELXY_IMAX",
    "vxy_flte": "PSC_VELXY_FLTE", "vxy_ff": "PSC_VELXY_FF", "z_p": "PSC_POSZ_P", "vz_p": "PSC_VELZ_P", "vz_i": "PSC_VELZ_I",
    "vz_d": "PSC_VELZ_D", "vz_flte": "PSC_VELZ_FLTE", "vz_ff": "PSC_VELZ_FF", "az_p": "PSC_ACCZ_P", "az_i": "PSC_ACCZ_I",
    "az_d": "PSC_ACCZ_D", "az_imax": "PSC_ACCZ_IMAX", "az_ff": "PSC_ACCZ_FF",
}  # fmt: skip
NAMES_47 = {
    "xy_p": "PSC_NE_POS_P", "vxy_p": "PSC_NE_VEL_P", "vxy_i": "PSC_NE_VEL_I", "vxy_d": "PSC_NE_VEL_D",
    "vxy_imax": "PSC_NE_VEL_IMAX", "vxy_flte": "PSC_NE_VEL_FLTE", "vxy_ff": "PSC_NE_VEL_FF", "z_p": "PSC_D_POS_P",
    "vz_p": "PSC_D_VEL_P", "vz_i": "PSC_D_VEL_I", "vz_d": "PSC_D_VEL_D", "vz_flte": "PSC_D_VEL_FLTE", "vz_ff": "PSC_D_VEL_FF",
    "az_p": "PSC_D_ACC_P", "az_i": "PSC_D_ACC_I", "az_d": "PSC_D_ACC_D", "az_imax": "PSC_D_ACC_IMAX", "az_ff": "PSC_D_ACC_FF",
}  # fmt: skip

VERTICAL_GAINS = "z.kp, z.ki, z.kd or --set accel_gain"
# Role -> unit, what of ours it follows from.
ROLES = {
    "xy_p": ("1/s", "x.kp, x.ki or x.kd"),
    "vxy_p": ("1/s", "x.kd"),
    "vxy_i": ("1/s2", "x.ki"),
    "vxy_d": ("1", OFF),
    "vxy_flte": ("Hz", OFF),
    "vxy_ff": ("1/s", OFF),
    "z_p": ("1/s", VERTICAL_GAINS),
    "vz_p": ("1/s", VERTICAL_GAINS),
    "vz_i": ("1/s2", OFF),
    "vz_d": ("1", OFF),
    "vz_flte": ("Hz", OFF),
    "vz_ff": ("1/s", OFF),
    "az_d": ("throttle", OFF),
    "az_ff": ("throttle", OFF),
}
# Role -> low, high, default.
RANGES_46 = {
    "xy_p": (0.5, 2.0, 1.0), "vxy_p": (0.1, 6.0, 2.0), "vxy_i": (0.0, 1.0, 1.0), "vxy_d": (0.0, 1.0, 0.25),
    "vxy_imax": (0.0, 4500.0, 1000.0), "vxy_flte": (0.0, 100.0, 5.0), "vxy_ff": (0.0, 6.0, 0.0), "z_p": (1.0, 3.0, 1.0),
    "vz_p": (1.0, 8.0, 5.0), "vz_i": (0.0, 1.0, 0.0), "vz_d": (0.0, 1.0, 0.0), "vz_flte": (0.0, 100.0, 5.0),
    "vz_ff": (0.0, 1.0, 0.0), "az_p": (0.2, 1.5, 0.5), "az_i": (0.0, 3.0, 1.0), "az_d": (0.0, 0.4, 0.0),
    "az_imax": (0.0, 1000.0, 800.0), "az_ff": (0.0, 0.5, 0.0),
}  # fmt: skip
RANGES_47 = {
    "xy_p": (0.5, 4.0, 1.0), "vxy_p": (0.1, 10.0, 2.0), "vxy_i": (0.0, 10.0, 1.0), "vxy_d": (0.0, 1.0, 0.25),
    "vxy_imax": (0.0, 10.0, 10.0), "vxy_flte": (0.0, 100.0, 5.0), "vxy_ff": (0.0, 10.0, 0.0), "z_p": (0.5, 4.0, 1.0),
    "vz_p": (1.0, 10.0, 5.0), "vz_i": (0.0, 10.0, 0.0), "vz_d": (0.0, 2.0, 0.0), "vz_flte": (0.0, 100.0, 5.0),
    "vz_ff": (0.0, 2.0, 0.0), "az_p": (0.01, 0.25, 0.05), "az_i": (0.0, 0.5, 0.1), "az_d": (0.0, 0.1, 0.0),
    "az_imax": (0.0, 1.0, 0.8), "az_ff": (0.0, 0.1, 0.0),
}  # fmt: skip


# Gain of ArduPilot's own rate loop -> end of the parameter's name.
RATE_TERMS = {
    "p": "P", "i": "I", "d": "D", "ff": "FF", "i_limit": "IMAX", "target_cutoff": "FLTT", "error_cutoff": "FLTE",
    "d_cutoff": "FLTD",
}  # fmt: skip
NATIVE_ATTITUDE = NativeLaw(
    "ardupilot",
    {
        axis: {
            "angle_p": f"ATC_ANG_{short}_P",
            "gyro_cutoff": "INS_GYRO_FILTER",
            **{gain: f"ATC_RAT_{short}_{term}" for gain, term in RATE_TERMS.items()},
        }
        for axis, short in SHORT.items()
    },
    frozenset({"p", "i", "d", "ff", "i_limit"}),
)


def _rate(name: str, ours: str, p: tuple[float, float, float], i: tuple[float, float, float]) -> list[ParameterInfo]:
    """Return one angle and rate loop; p, i: low, high, default."""
    rate, yaw = f"ATC_RAT_{name}", name == "YAW"
    flte = (0.0, 20.0, 2.5) if yaw else (0.0, 100.0, 0.0)
    fltt = (1.0, 50.0, 20.0) if yaw else (5.0, 100.0, 20.0)
    return [
        ParameterInfo(f"ATC_ANG_{name}_P", "1/s", 3.0, 12.0, 4.5, f"{ours}.kp, {ours}.ki or {ours}.kd"),
        ParameterInfo(f"{rate}_P", f"{TORQUE} per rad/s", *p, f"{ours}.kd"),
        ParameterInfo(f"{rate}_I", f"{TORQUE} per rad", *i, f"{ours}.ki"),
        ParameterInfo(f"{rate}_D", f"{TORQUE} per rad/s2", 0.0, 0.02 if yaw else 0.05, 0.0 if yaw else 0.0036, OFF),
        ParameterInfo(f"{rate}_FF", f"{TORQUE} per rad/s", 0.0, 0.5, 0.0, OFF),
        ParameterInfo(f"{rate}_D_FF", f"{TORQUE} per rad/s2", 0.0, 0.02, 0.0, OFF),
        ParameterInfo(f"{rate}_IMAX", TORQUE, 0.0, 1.0, 0.5, "nothing: it is the whole torque"),
        ParameterInfo(f"{rate}_FLTT", "Hz", *fltt, "nothing: it is the highest documented"),
        ParameterInfo(f"{rate}_FLTE", "Hz", *flte, "controller.yaw_torque_cutoff" if yaw else OFF),
        ParameterInfo(f"{rate}_SMAX", "1/s", 0.0, 200.0, 0.0, OFF),
    ]


def _dialect(
    firmware: str,
    names: Mapping[str, str],
    ranges: Mapping[str, tuple[float, float, float]],
    scale: float,
    metre: float,
    full_scale: float,
) -> Dialect:
    gain = "throttle per m/s2" if scale == 1.0 else "1/10 throttle per m/s2"
    units = ROLES | {"az_p": (gain, "the airframe or --set accel_gain"), "az_i": (f"{gain} and s", VERTICAL_GAINS)}
    units |= {"vxy_imax": ("m/s2" if metre == 1.0 else "cm/s2", "nothing: it is 10 m/s2")}
    units |= {"az_imax": ("throttle" if full_scale == 1.0 else "1/1000 throttle", "nothing: it is the whole throttle")}
    position = [ParameterInfo(names[role], units[role][0], *ranges[role], units[role][1]) for role in names]
    attitude = [
        *_rate("RLL", "roll", (0.01, 0.5, 0.135), (0.01, 2.0, 0.135)),
        *_rate("PIT", "pitch", (0.01, 0.5, 0.135), (0.01, 2.0, 0.135)),
        *_rate("YAW", "yaw", (0.1, 2.5, 0.18), (0.01, 1.0, 0.018)),
    ]
    common = [
        ParameterInfo("PSC_ANGLE_MAX", "deg", 0.0, 45.0, 0.0, "controller.tilt_limit"),
        ParameterInfo("MOT_THST_EXPO", "1", -1.0, 1.0, 0.65, "--set thrust_curve"),
        ParameterInfo("MOT_THST_HOVER", "1", 0.2, 0.8, 0.35, "the airframe"),
    ]
    cascades = {
        axis: CascadeNames(f"ATC_ANG_{short}_P", *(f"ATC_RAT_{short}_{term}" for term in "PID"))
        for axis, short in SHORT.items()
    } | {"x": CascadeNames(*(names[role] for role in ("xy_p", "vxy_p", "vxy_i", "vxy_d")))}
    native_table = [
        ParameterInfo("INS_GYRO_FILTER", "Hz", 0.0, 256.0, 20.0, "attitude.gyro_cutoff"),
        *(
            ParameterInfo(
                f"ATC_RAT_{short}_FLTD", "Hz", 0.0, 50.0 if axis == "yaw" else 100.0, 20.0, f"{axis}.d_cutoff"
            )
            for axis, short in SHORT.items()
        ),
    ]
    carried_names = {name for entries in cascades.values() for name in entries[:3]} | {names[role] for role in VERTICAL}
    return Dialect(
        target="ardupilot",
        name=f"ArduPilot Copter {firmware}",
        file="gainproof.param",
        table={entry.name: entry for entry in (*attitude, *position, *common)},
        names=cascades,
        # The P gain on the acceleration is free, and so not among them.
        carried=frozenset(carried_names | {TILT, YAW_FILTER}),
        scaling=(EXPO, *(names[role] for role in SCALING)),
        yaw_filter=YAW_FILTER,
        gyro="INS_GYRO_FILTER",
        gyro_cutoff=20.0,
        firmware=firmware,
        roles=names,
        acceleration=scale,
        metre=metre,
        full_scale=full_scale,
        native=(NATIVE_ATTITUDE,),
        native_table={entry.name: entry for entry in native_table},
    )


# What acts in or around these loops and is never written begins with one of these: an import names it where a file has it.
AROUND = (
    "ATC_",
    "PSC_",
    "MOT_",
    "INS_GYRO_FILTER",
    "INS_HNTCH_",
    "INS_HNTC2_",
    "SCHED_LOOP_RATE",
    "ANGLE_MAX",
    "ACRO_BAL_",
    "FRAME_CLASS",
    "FRAME_TYPE",
)


def translated(values: Values, source: Dialect, target: Dialect) -> dict[str, float]:
    """Return parameters with names and units of another dialect; unknown names stay."""
    if source.firmware == target.firmware:
        return dict(values)
    units = {
        **dict.fromkeys(("az_p", "az_i", "az_d", "az_ff"), source.acceleration / target.acceleration),
        "vxy_imax": target.metre / source.metre,
        "az_imax": target.full_scale / source.full_scale,
    }
    roles = {name: role for role, name in source.roles.items()}
    translated_values = {
        target.roles[roles[name]] if name in roles else name: units.get(roles.get(name, ""), 1.0) * value
        for name, value in values.items()
    }
    for name, (other, unit) in LEAN_ANGLE[target.firmware].items():
        if other in translated_values:
            translated_values[name] = unit * translated_values.pop(other)
    return translated_values


# Firmware -> its name of the lean angle -> the other's, and what one unit of that is in its own.
LEAN_ANGLE = {"4.6": {"ANGLE_MAX": ("ATC_ANGLE_MAX", 100.0)}, "4.7": {"ATC_ANGLE_MAX": ("ANGLE_MAX", 0.01)}}


def check_names(values: Values, dialect: Dialect, file: ReadableFile) -> None:
    """Refuse a file with names of the other version; raises InputError that names the right one."""
    for other in DIALECTS.values():
        foreign = sorted((set(other.roles.values()) - set(dialect.roles.values())) & set(values))
        if foreign:
            raise InputError(
                f"is a name of Copter {other.firmware}, and the file is read as {dialect.firmware}: units differ by up to 1000; "
                f"give --firmware {other.firmware}",
                file=file,
                key=foreign[0],
            )


# 4.6 works in cm/s2 and 1/1000 of throttle, so its acceleration gains are ten times those of 4.7, which works in m/s2.
DIALECTS = {
    "4.6": _dialect("4.6", NAMES_46, RANGES_46, 0.1, 100.0, 1000.0),
    "4.7": _dialect("4.7", NAMES_47, RANGES_47, 1.0, 1.0, 1.0),
}


# What counts as above 0 there: FLT_EPSILON of is_positive.
SMALLEST = 1.1920929e-7
POSITIVE_ROLES = ("xy_p", "z_p", "vz_p", "az_p", "az_i")
BALANCE = {"ACRO_BAL_ROLL": "ATC_ANG_RLL_P", "ACRO_BAL_PITCH": "ATC_ANG_PIT_P"}


def check_arming(values: Values, dialect: Dialect) -> None:
    """Raise InputError for parameters that prevent arming; values: of the vehicle with the file."""
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


def positive_names(values: Values, dialect: Dialect) -> list[str]:
    """Return the names that must be above 0; P and I of a rate loop may be 0 with feed-forward."""
    names = [*dialect.named(*POSITIVE_ROLES), *(f"ATC_ANG_{short}_P" for short in SHORT.values())]
    for short in SHORT.values():
        if not values.get(f"ATC_RAT_{short}_FF", 0.0) >= SMALLEST:
            names += (f"ATC_RAT_{short}_P", f"ATC_RAT_{short}_I")
    return names
