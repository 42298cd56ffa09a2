"""Parameters of PX4 1.16 that an export writes: units, ranges, defaults.

PX4/PX4-Autopilot, release 1.16: src/modules/mc_rate_control/mc_rate_control_params.c, mc_att_control/mc_att_control_params.c,
mc_pos_control/multicopter_position_control_{gain,}_params.c and ..._limits_params.c, src/lib/mixer_module/params.c. PX4 documents
these ranges and does not enforce them.

MPC_XY_VEL_D_ACC is documented from 0.1 on; 0 stands here, for it switches a term off that our law does not have, and the source
(PositionControl.cpp) takes it as any other number.
"""

from tuner.exchange.autopilot.parameter_table import Entry, unbounded

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
