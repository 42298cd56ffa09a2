"""Parameter files as vehicles have them: some typed from what public airframes set, some drawn from the documented ranges."""

from dataclasses import dataclass

import numpy as np

from plant.seeds import generator

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
PX4_OTHERS = {"SYS_AUTOSTART": (4001, 6), "COM_RC_IN_MODE": (1, 6), "BAT1_V_CHARGED": (4.05, 9), "NAV_ACC_RAD": (2.0, 9)}
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


@dataclass(frozen=True)
class VehicleFile:
    """name: of the case; text: of the file; values: of every parameter in it; settings: of the import."""

    name: str
    text: str
    values: dict[str, float]
    settings: tuple[str, ...] = ()


def drawn(ranges: dict[str, tuple[float, float]], name: str, index: int) -> dict[str, float]:
    """Values from ranges, as float32."""
    stream = generator(SEED, name, index)
    return {key: float(np.float32(stream.uniform(low, high))) for key, (low, high) in ranges.items()}


def px4_file(name: str, values: dict[str, float], settings: tuple[str, ...] = (), long: bool = True) -> VehicleFile:
    """A file of QGroundControl; long: with 18 decimals, as it wrote reals for years."""
    rows = {key: (value, 6 if key in ("MPC_USE_HTE", "MC_AIRMODE") else 9) for key, value in values.items()} | PX4_OTHERS
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
