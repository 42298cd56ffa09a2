"""Parameter files as vehicles have them: some typed from what public airframes set, some drawn from the documented ranges."""

from dataclasses import dataclass

import numpy as np

from plant.seeds import generator
from tuner.extensions.ardupilot.ranges import DIALECTS

SEED = 14
PX4_HEAD = """# Onboard parameters for Vehicle 1
#
# Stack: PX4 Pro
# Vehicle: Multi-Rotor
# Version: {version}
# Git Revision: 0123456789abcdef
#
# Vehicle-Id Component-Id Name Value Type
"""
# Documented ranges of PX4's module parameters; where one has no upper end, a generous one.
PX4_RANGES = {
    "MC_ROLL_P": (0.0, 12.0), "MC_PITCH_P": (0.0, 12.0), "MC_YAW_P": (0.0, 5.0), "MC_YAW_WEIGHT": (0.0, 1.0),
    "MC_YAW_TQ_CUTOFF": (0.0, 10.0),
    "MC_ROLLRATE_P": (0.01, 0.5), "MC_ROLLRATE_I": (0.0, 1.0), "MC_ROLLRATE_D": (0.0, 0.01), "MC_ROLLRATE_FF": (0.0, 0.1),
    "MC_ROLLRATE_K": (0.01, 5.0), "MC_RR_INT_LIM": (0.0, 1.0),
    "MC_PITCHRATE_P": (0.01, 0.6), "MC_PITCHRATE_I": (0.0, 1.0), "MC_PITCHRATE_D": (0.0, 0.01), "MC_PITCHRATE_FF": (0.0, 0.1),
    "MC_PITCHRATE_K": (0.01, 5.0), "MC_PR_INT_LIM": (0.0, 1.0),
    "MC_YAWRATE_P": (0.0, 0.6), "MC_YAWRATE_I": (0.0, 1.0), "MC_YAWRATE_D": (0.0, 0.01), "MC_YAWRATE_FF": (0.0, 0.1),
    "MC_YAWRATE_K": (0.01, 5.0), "MC_YR_INT_LIM": (0.0, 1.0),
    "MPC_XY_P": (0.0, 2.0), "MPC_XY_VEL_P_ACC": (1.2, 5.0), "MPC_XY_VEL_I_ACC": (0.0, 60.0), "MPC_XY_VEL_D_ACC": (0.1, 2.0),
    "MPC_Z_P": (0.1, 1.5), "MPC_Z_VEL_P_ACC": (2.0, 15.0), "MPC_Z_VEL_I_ACC": (0.2, 3.0), "MPC_Z_VEL_D_ACC": (0.0, 2.0),
    "MPC_THR_HOVER": (0.1, 0.8), "MPC_TILTMAX_AIR": (20.0, 89.0), "THR_MDL_FAC": (0.0, 1.0), "IMU_GYRO_CUTOFF": (20.0, 120.0),
    "IMU_DGYRO_CUTOFF": (10.0, 100.0), "MC_ROLLRATE_MAX": (0.0, 1800.0),
}  # fmt: skip
# Of no concern to these loops.
PX4_OTHERS = {
    "SYS_AUTOSTART": (4001, 6),
    "COM_RC_IN_MODE": (1, 6),
    "BAT1_V_CHARGED": (4.05, 9),
    "NAV_ACC_RAD": (2.0, 9),
}
# What public airframes set differently from PX4's defaults; MC_* of a small racer, a camera vehicle, a training vehicle.
PX4_TYPED = (
    {"MC_ROLLRATE_P": 0.15, "MC_ROLLRATE_I": 0.2, "MC_ROLLRATE_D": 0.003, "MC_ROLL_P": 6.5, "THR_MDL_FAC": 0.3},
    {
        "MC_ROLLRATE_P": 0.076, "MC_ROLLRATE_I": 0.3, "MC_ROLLRATE_D": 0.0012, "MC_ROLL_P": 8.0, "MC_PITCHRATE_P": 0.082,
        "MC_PITCHRATE_I": 0.35, "MC_PITCHRATE_D": 0.0012, "MC_PITCH_P": 8.0, "MC_YAWRATE_P": 0.25, "MC_YAWRATE_I": 0.3,
        "MC_YAW_P": 4.0, "THR_MDL_FAC": 0.3, "MPC_THR_HOVER": 0.25, "IMU_GYRO_CUTOFF": 120.0, "IMU_DGYRO_CUTOFF": 45.0,
    },
    {"MC_ROLLRATE_K": 1.3, "MC_PITCHRATE_K": 1.3, "MPC_TILTMAX_AIR": 80.0, "MPC_USE_HTE": 1.0, "MC_YAW_WEIGHT": 0.4},
    # The integral is faster than the angle loop: the split of the file is the smaller root.
    {"MC_ROLLRATE_P": 0.05, "MC_ROLLRATE_I": 0.5, "MC_ROLL_P": 4.0, "MPC_XY_P": 0.5, "MPC_XY_VEL_I_ACC": 5.0},
    # A double root, no angle loop, and no proportional gain.
    {
        "MC_ROLLRATE_P": 0.2, "MC_ROLLRATE_I": 0.8, "MC_ROLL_P": 4.0, "MC_PITCH_P": 0.0, "MC_YAWRATE_P": 0.0,
        "MC_YAWRATE_I": 0.2, "MC_RR_INT_LIM": 0.3,
    },
    {"MPC_XY_VEL_P_ACC": 1.8, "MPC_XY_VEL_D_ACC": 0.2, "MPC_Z_VEL_D_ACC": 0.1, "MPC_THR_HOVER": 0.5, "THR_MDL_FAC": 0.0},
)  # fmt: skip


# Documented ranges of Copter 3.3, and of 3.4 and 3.5, which had the rate loops under their present names.
TERMS = (("P", (0.08, 0.3)), ("I", (0.01, 0.5)), ("D", (0.0, 0.02)))
ARDUPILOT_33 = {
    **{f"RATE_{axis}_{term}": span for axis in ("RLL", "PIT") for term, span in
       (*TERMS, ("IMAX", (0.0, 4500.0)), ("FILT_HZ", (1.0, 100.0)))},
    "RATE_YAW_P": (0.15, 0.5), "RATE_YAW_I": (0.01, 0.05), "RATE_YAW_D": (0.0, 0.02), "RATE_YAW_FILT_HZ": (1.0, 20.0),
    "STB_RLL_P": (3.0, 12.0), "STB_PIT_P": (3.0, 12.0), "STB_YAW_P": (3.0, 6.0), "POS_XY_P": (0.5, 2.0), "VEL_XY_P": (0.1, 6.0),
    "VEL_XY_I": (0.02, 1.0), "VEL_XY_IMAX": (0.0, 4500.0), "POS_Z_P": (1.0, 3.0), "VEL_Z_P": (1.0, 8.0),
    "ACCEL_Z_P": (0.5, 1.5), "ACCEL_Z_I": (0.1, 3.0), "ACCEL_Z_D": (0.0, 0.4), "THR_MID": (300.0, 700.0),
}  # fmt: skip
ARDUPILOT_34 = {
    **{f"ATC_RAT_{axis}_{term}": span for axis in ("RLL", "PIT") for term, span in
       (*TERMS, ("IMAX", (0.0, 1.0)), ("FILT", (1.0, 100.0)))},
    "ATC_RAT_YAW_P": (0.15, 0.5), "ATC_RAT_YAW_I": (0.01, 0.05), "ATC_RAT_YAW_FILT": (1.0, 20.0), "ATC_ANG_RLL_P": (3.0, 12.0),
    "ATC_ANG_PIT_P": (3.0, 12.0), "ATC_ANG_YAW_P": (3.0, 6.0), "POS_XY_P": (0.5, 2.0), "VEL_XY_P": (0.1, 6.0),
    "VEL_XY_I": (0.02, 1.0), "POS_Z_P": (1.0, 3.0), "VEL_Z_P": (1.0, 8.0), "ACCEL_Z_P": (0.5, 1.5), "ACCEL_Z_I": (0.1, 3.0),
    "ACCEL_Z_FILT_HZ": (1.0, 100.0), "MOT_THST_EXPO": (0.25, 0.8), "MOT_THST_HOVER": (0.2, 0.8),
}  # fmt: skip
# Names and factors of the update from 3.3 to 3.4 and on, typed from its table; frame X.
UPDATED = {
    **{f"RATE_{a}_{t}": ((f"ATC_RAT_{a}_{t}",), 0.9) for a in ("RLL", "PIT", "YAW") for t in "PID"},
    **{f"RATE_{a}_IMAX": ((f"ATC_RAT_{a}_IMAX",), 1.0 / 4500.0) for a in ("RLL", "PIT", "YAW")},
    **{f"{old}{a}_{end}": ((f"ATC_RAT_{a}_FLTD", f"ATC_RAT_{a}_FLTT"), 1.0)
       for old, end in (("RATE_", "FILT_HZ"), ("ATC_RAT_", "FILT")) for a in ("RLL", "PIT")},
    "RATE_YAW_FILT_HZ": (("ATC_RAT_YAW_FLTE",), 1.0), "ATC_RAT_YAW_FILT": (("ATC_RAT_YAW_FLTE",), 1.0),
    **{f"STB_{a}_P": ((f"ATC_ANG_{a}_P",), 1.0) for a in ("RLL", "PIT", "YAW")},
    "POS_XY_P": (("PSC_POSXY_P",), 1.0), "VEL_XY_P": (("PSC_VELXY_P",), 1.0), "VEL_XY_I": (("PSC_VELXY_I",), 1.0),
    "VEL_XY_IMAX": (("PSC_VELXY_IMAX",), 1.0), "POS_Z_P": (("PSC_POSZ_P",), 1.0), "VEL_Z_P": (("PSC_VELZ_P",), 1.0),
    "ACCEL_Z_P": (("PSC_ACCZ_P",), 1.0), "ACCEL_Z_I": (("PSC_ACCZ_I",), 1.0), "ACCEL_Z_D": (("PSC_ACCZ_D",), 1.0),
    "ACCEL_Z_FILT_HZ": (("PSC_ACCZ_FLTE",), 1.0), "THR_MID": (("MOT_THST_HOVER",), 0.001),
}  # fmt: skip
ARDUPILOT_OTHERS = {"RC1_MAX": 2000.0, "BATT_CAPACITY": 5200.0, "COMPASS_OFS_X": -12.5, "WP_YAW_BEHAVIOR": 2.0}
# What Copter has by default, and what two kinds of vehicle set differently: a small racer, a slow lifter.
ARDUPILOT_TYPED = (
    {
        "ATC_ANG_RLL_P": 4.5, "ATC_ANG_PIT_P": 4.5, "ATC_ANG_YAW_P": 4.5, "ATC_RAT_RLL_P": 0.135, "ATC_RAT_RLL_I": 0.135,
        "ATC_RAT_RLL_D": 0.0036, "ATC_RAT_YAW_P": 0.18, "ATC_RAT_YAW_I": 0.018, "ATC_RAT_YAW_FLTE": 2.5, "PSC_ACCZ_P": 0.5,
        "PSC_ACCZ_I": 1.0, "PSC_VELZ_P": 5.0, "PSC_POSZ_P": 1.0, "MOT_THST_EXPO": 0.65, "MOT_THST_HOVER": 0.35,
        "ANGLE_MAX": 3000.0, "PSC_ANGLE_MAX": 0.0, "INS_GYRO_FILTER": 20.0,
    },
    {
        "ATC_ANG_RLL_P": 12.0, "ATC_RAT_RLL_P": 0.06, "ATC_RAT_RLL_I": 0.9, "ATC_RAT_RLL_FLTT": 40.0, "MOT_THST_EXPO": 0.55,
        "MOT_THST_HOVER": 0.2, "ANGLE_MAX": 7000.0, "INS_GYRO_FILTER": 80.0, "MOT_SPIN_MIN": 0.08,
    },
    # Three roots of the vertical cubic in one place: 2 1/s.
    {"PSC_POSZ_P": 1.0, "PSC_VELZ_P": 4.0, "PSC_ACCZ_P": 0.5, "PSC_ACCZ_I": 1.0, "PSC_VELZ_I": 0.2, "PSC_ANGLE_MAX": 25.0},
)  # fmt: skip


@dataclass(frozen=True)
class VehicleFile:
    """name: of the case; text: of the file; values: of every parameter in it, under the names that the vehicle has when an export
    is loaded; settings: of the import; others: of no concern to the loops.
    """

    name: str
    text: str
    values: dict[str, float]
    settings: tuple[str, ...] = ()
    others: frozenset[str] = frozenset(PX4_OTHERS)


def drawn(ranges: dict[str, tuple[float, float]], name: str, index: int) -> dict[str, float]:
    """Values from ranges, as float32."""
    stream = generator(SEED, name, index)
    return {key: float(np.float32(stream.uniform(low, high))) for key, (low, high) in ranges.items()}


def px4_file(name: str, values: dict[str, float], settings: tuple[str, ...] = (), long: bool = True) -> VehicleFile:
    """A file of QGroundControl; long: with 18 decimals, as it wrote reals for years."""
    rows = {
        key: (value, 6 if key in ("MPC_USE_HTE", "MC_AIRMODE") else 9) for key, value in values.items()
    } | PX4_OTHERS
    lines = [
        f"1\t1\t{key}\t{int(value) if kind == 6 else f'{np.float32(value):.18f}' if long else repr(float(value))}\t{kind}\n"
        for key, (value, kind) in sorted(rows.items())
    ]
    held = {key: float(np.float32(value)) for key, (value, _) in rows.items()}
    return VehicleFile(name, PX4_HEAD.format(version="1.16.0") + "".join(lines), held, settings)


def px4_files() -> list[VehicleFile]:
    """Twenty: six typed, fourteen drawn; every third of those lacks a third of its lines."""
    files = [px4_file(f"typed-{i}", values, long=False) for i, values in enumerate(PX4_TYPED)]
    for i in range(14):
        values = drawn(PX4_RANGES, "px4 files", i)
        if i % 3 == 2:
            values = dict(list(values.items())[i % 2 :: 2])
        settings = ((), ("thrust_curve=0.4",), ("rate_derivative=inertia",), ("thrust_curve=0",))[i % 4]
        files.append(px4_file(f"drawn-{i}", values, settings, long=i % 2 == 0))
    return files


# Generous ranges of the Crazyflie's parameters: it documents none.
CRAZYFLIE_RANGES = {
    **{f"pid_rate.{axis}_{term}": span for axis in ("roll", "pitch", "yaw") for term, span in
       (("kp", (50.0, 900.0)), ("ki", (10.0, 1500.0)), ("kd", (0.0, 10.0)), ("kff", (0.0, 50.0)))},
    **{f"pid_attitude.{axis}_{term}": span for axis in ("roll", "pitch", "yaw") for term, span in
       (("kp", (2.0, 20.0)), ("ki", (0.0, 20.0)), ("kd", (0.0, 1.0)))},
    **{f"velCtlPid.v{axis}{term}": span for axis in "xyz" for term, span in
       (("Kp", (5.0, 40.0)), ("Ki", (0.1, 20.0)), ("Kd", (0.0, 2.0)))},
    **{f"posCtlPid.{axis}Kp": (0.5, 4.0) for axis in "xyz"},
    "posCtlPid.zKi": (0.0, 1.0), "pid_rate.omxFiltCut": (20.0, 120.0), "pid_rate.omyFiltCut": (20.0, 120.0),
    "pid_rate.omzFiltCut": (20.0, 120.0),
}  # fmt: skip
CRAZYFLIE_OTHERS = {"stabilizer.controller": 1.0, "ring.effect": 7.0}
# The firmware's own defaults, what a heavier vehicle sets, and integrals of position that are faster than its outer loop.
CRAZYFLIE_TYPED = (
    {"pid_rate.roll_kp": 250.0, "pid_attitude.yaw_kd": 0.35, "posCtlPid.zKi": 0.5},
    {"pid_rate.roll_kp": 180.0, "pid_rate.pitch_kp": 180.0, "pid_attitude.roll_ki": 0.0, "pid_rate.yaw_kd": 1.5},
    {"velCtlPid.vzKi": 60.0, "velCtlPid.vzKp": 10.0, "posCtlPid.zKp": 1.5},
)


def crazyflie_file(name: str, values: dict[str, float], block: bool, *settings: str) -> VehicleFile:
    """A file of cflib; block: each parameter over four lines, as PyYAML writes them."""
    lines = ["type: persistent_param_state", "version: '1'", "params:"]
    for key, value in {**values, **CRAZYFLIE_OTHERS}.items():
        fields = {"is_stored": "true", "default_value": "0.0", "stored_value": repr(value)}
        parts = [f"{field}: {text}" for field, text in fields.items()]
        lines += [f"  {key}:", *(f"    {part}" for part in parts)] if block else [f"  {key}: {{{', '.join(parts)}}}"]
    return VehicleFile(
        name, "\n".join(lines) + "\n", {**values, **CRAZYFLIE_OTHERS}, settings, frozenset(CRAZYFLIE_OTHERS)
    )


def crazyflie_files() -> list[VehicleFile]:
    """Twenty: three typed, seventeen drawn; every third of those lacks half of its lines, every other one filters D."""
    files = [crazyflie_file(f"typed-{i}", values, i == 1) for i, values in enumerate(CRAZYFLIE_TYPED)]
    for i in range(17):
        values = drawn(CRAZYFLIE_RANGES, "crazyflie files", i)
        values = {name: value for name, value in values.items() if i % 2 or "FiltCut" not in name}
        values |= {"pid_rate.rateFiltEn": float(i % 2)}
        if i % 3 == 2:
            values = {name: value for k, (name, value) in enumerate(values.items()) if k % 2 or "Filt" in name}
        files.append(crazyflie_file(f"drawn-{i}", values, i % 4 == 1, *(("full_thrust=0.14",) if i % 5 == 4 else ())))
    return files


def ardupilot_file(
    name: str, values: dict[str, float], firmware: str, layout: int, *settings: str, banner: str = ""
) -> VehicleFile:
    """A file of Mission Planner, MAVProxy or QGroundControl (layout 0, 1, 2)."""
    rows = {**values, **ARDUPILOT_OTHERS}
    held: dict[str, float] = {}
    lines = [f"# {banner}\n"] if banner else []
    for key, value in sorted(rows.items()):
        one = float(np.float32(value))
        new, factor = UPDATED.get(key, ((key,), 1.0))
        held |= dict.fromkeys(new, factor * one)
        text = repr(float(str(np.float32(value))))
        lines.append((f"{key},{text}\n", f"{key:<16} {text}\n", f"1\t1\t{key}\t{text}\t9\n")[layout])
    head = (
        PX4_HEAD.replace("PX4 Pro", "ArduPilot").format(version=f"{firmware}.1") if layout == 2 and not banner else ""
    )
    options = (f"firmware={firmware}", *settings)
    return VehicleFile(name, head + "".join(lines), held, options, frozenset(ARDUPILOT_OTHERS))


def ardupilot_files() -> list[VehicleFile]:
    """Twenty: three typed, eleven drawn from the ranges of 4.6 and 4.7, six of Copter 3.3 to 3.5."""
    files = [ardupilot_file(f"typed-{i}", values, "4.6", i) for i, values in enumerate(ARDUPILOT_TYPED)]
    for i in range(11):
        firmware = ("4.6", "4.7")[i % 2]
        ranges = {name: (entry.low, entry.high) for name, entry in DIALECTS[firmware].table.items()}
        ranges["INS_GYRO_FILTER"] = (0.0, 256.0)
        ranges[("ANGLE_MAX", "ATC_ANGLE_MAX")[i % 2]] = ((1000.0, 8000.0), (10.0, 80.0))[i % 2]
        values = drawn(ranges, "ardupilot files", i)
        if i % 4 == 3:
            values = dict(list(values.items())[::2])
        settings = ((), ("thrust_curve=0.4",), ("rate_derivative=inertia",))[i % 3]
        files.append(ardupilot_file(f"drawn-{i}", values, firmware, i % 3, *settings))
    for i in range(3):
        old = drawn(ARDUPILOT_33, "ardupilot 3.3", i)
        files.append(ardupilot_file(f"copter-3.3-{i}", old, "4.6", i, banner="ArduCopter V3.3.3 (acf2e10c)"))
        old = drawn(ARDUPILOT_34, "ardupilot 3.4", i)
        files.append(ardupilot_file(f"copter-3.4-{i}", old, "4.6", i, banner="ArduCopter V3.4.6 (e707341b)"))
    return files
