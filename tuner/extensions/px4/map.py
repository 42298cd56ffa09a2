"""Our PID as the parameters of PX4's cascade, and back.

PX4 has an angle loop P around a rate loop PI in normalised torque, and a position loop P around a velocity loop PI in m/s2. Its
acceleration becomes tilt and thrust with g = 9.80665 m/s2 and the hover thrust; what the vehicle then does differs by the local
gravity, and along z by how thrust follows the command.

Parameters of PX4 1.16 that an export writes: units, ranges, defaults.

PX4/PX4-Autopilot, release 1.16: src/modules/mc_rate_control/mc_rate_control_params.c, mc_att_control/mc_att_control_params.c,
mc_pos_control/multicopter_position_control_{gain,}_params.c and ..._limits_params.c, src/lib/mixer_module/params.c. PX4 documents
these ranges and does not enforce them.

MPC_XY_VEL_D_ACC is documented from 0.1 on; 0 stands here, for it switches a term off that our law does not have, and the source
(PositionControl.cpp) takes it as any other number.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import degrees, radians

from plant.quadrotor.cascade import ATTITUDE_AXES
from tuner.exchange.target import whole_number
from tuner.extensions.autopilots.cascade import Autopilot, CascadeNames, ParameterSet
from tuner.extensions.autopilots.native_loops import NativeLaw
from tuner.extensions.autopilots.parameters import ParameterInfo, Values, parameter_table, unbounded
from tuner.extensions.autopilots.pid import SAME, held_tilt
from tuner.extensions.autopilots.scales import command_slope, hover_share, linearizing_model, px4_factors, torque_scale
from tuner.extensions.px4.text import VERSION, write_params

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
) -> list[ParameterInfo]:
    """Return one rate loop.

    Args:
        axis: Axis in the parameters' names.
        ours: Axis in the names of our gains.
        limit: Parameter of the integral limit.
        p: Low, high and default value of P.
        i: Default value of I.
        d: High and default value of D.
    """
    name = f"MC_{axis}RATE"
    off = "nothing: it is switched off"
    return [
        ParameterInfo(f"{name}_P", f"{TORQUE} per rad/s", *p, f"{ours}.kd"),
        unbounded(f"{name}_I", f"{TORQUE} per rad", 0.0, i, f"{ours}.ki"),
        ParameterInfo(f"{name}_D", f"{TORQUE} per rad/s2", 0.0, *d, off),
        unbounded(f"{name}_FF", f"{TORQUE} per rad/s", 0.0, 0.0, off),
        ParameterInfo(f"{name}_K", "1", 0.01, 5.0, 1.0, "nothing: it is 1"),
        unbounded(limit, TORQUE, 0.0, 0.3, "nothing: it is the whole torque"),
    ]


TABLE = parameter_table(
    *_rate("ROLL", "roll", "MC_RR_INT_LIM", (0.01, 0.5, 0.15), 0.2, (0.01, 0.003)),
    *_rate("PITCH", "pitch", "MC_PR_INT_LIM", (0.01, 0.6, 0.15), 0.2, (1.0, 0.003)),
    *_rate("YAW", "yaw", "MC_YR_INT_LIM", (0.0, 0.6, 0.2), 0.1, (1.0, 0.0)),
    ParameterInfo("MC_ROLL_P", "1/s", 0.0, 12.0, 4.0, "roll.kp, roll.ki or roll.kd"),
    ParameterInfo("MC_PITCH_P", "1/s", 0.0, 12.0, 4.0, "pitch.kp, pitch.ki or pitch.kd"),
    ParameterInfo("MC_YAW_P", "1/s", 0.0, 5.0, 2.8, "yaw.kp, yaw.ki or yaw.kd"),
    ParameterInfo("MC_YAW_WEIGHT", "1", 0.0, 1.0, 0.4, "nothing: it is 1"),
    ParameterInfo("MC_YAW_TQ_CUTOFF", "Hz", 0.0, 10.0, 2.0, "controller.yaw_torque_cutoff"),
    ParameterInfo("MPC_XY_P", "1/s", 0.0, 2.0, 0.95, "x.kp, x.ki or x.kd"),
    ParameterInfo("MPC_XY_VEL_P_ACC", "1/s", 1.2, 5.0, 1.8, "x.kd"),
    ParameterInfo("MPC_XY_VEL_I_ACC", "1/s2", 0.0, 60.0, 0.4, "x.ki"),
    ParameterInfo("MPC_XY_VEL_D_ACC", "1", 0.0, 2.0, 0.2, "nothing: it is switched off"),
    ParameterInfo("MPC_Z_P", "1/s", 0.1, 1.5, 1.0, "z.kp, z.ki or z.kd"),
    ParameterInfo("MPC_Z_VEL_P_ACC", "1/s", 2.0, 15.0, 4.0, "z.kd"),
    ParameterInfo("MPC_Z_VEL_I_ACC", "1/s2", 0.2, 3.0, 2.0, "z.ki"),
    ParameterInfo("MPC_Z_VEL_D_ACC", "1", 0.0, 2.0, 0.0, "nothing: it is switched off"),
    ParameterInfo("MPC_THR_HOVER", "1", 0.1, 0.8, 0.5, "the airframe"),
    ParameterInfo("MPC_TILTMAX_AIR", "deg", 20.0, 89.0, 45.0, "controller.tilt_limit"),
    ParameterInfo("THR_MDL_FAC", "1", 0.0, 1.0, 0.0, "--set thrust_curve"),
)


GRAVITY = 9.80665
HOVER, MODEL, TILT = "MPC_THR_HOVER", "THR_MDL_FAC", "MPC_TILTMAX_AIR"
THRUST_MODEL = "thrust_model"
# Rate of the attitude loops [Hz], and its default.
LOOP_RATE, USUAL_RATE = "IMU_GYRO_RATEMAX", 400.0
INTEGRAL_LIMITS = {"roll": "MC_RR_INT_LIM", "pitch": "MC_PR_INT_LIM", "yaw": "MC_YR_INT_LIM"}
# The same filter as ours, alpha = h/(h + tau).
YAW_FILTER = "MC_YAW_TQ_CUTOFF"
NAMES = {
    **{
        axis: CascadeNames(f"MC_{axis.upper()}_P", *(f"MC_{axis.upper()}RATE_{term}" for term in "PID"))
        for axis in ATTITUDE_AXES
    },
    **{
        axis: CascadeNames(f"MPC_{name}_P", *(f"MPC_{name}_VEL_{term}_ACC" for term in "PID"))
        for axis, name in (("x", "XY"), ("z", "Z"))
    },
}
# What acts in PX4's own loops, and beside ours does not enter.
NATIVE_TABLE = parameter_table(
    ParameterInfo("IMU_GYRO_CUTOFF", "Hz", 0.0, 1000.0, 40.0, "attitude.gyro_cutoff"),
    ParameterInfo("IMU_DGYRO_CUTOFF", "Hz", 0.0, 1000.0, 30.0, "attitude.d_cutoff"),
    ParameterInfo("IMU_GYRO_NF0_FRQ", "Hz", 0.0, 1000.0, 0.0, "attitude.notch"),
    ParameterInfo("IMU_GYRO_NF0_BW", "Hz", 0.0, 100.0, 20.0, "attitude.notch_width"),
    ParameterInfo("MPC_VELD_LP", "Hz", 0.0, 50.0, 5.0, "position.d_cutoff"),
)
SHARED = {
    "gyro_cutoff": "IMU_GYRO_CUTOFF",
    "d_cutoff": "IMU_DGYRO_CUTOFF",
    "notch": "IMU_GYRO_NF0_FRQ",
    "notch_width": "IMU_GYRO_NF0_BW",
}
NATIVE_ATTITUDE = NativeLaw(
    "px4",
    {
        axis: {
            **dict(zip(("angle_p", "p", "i", "d"), NAMES[axis], strict=True)),
            "ff": f"MC_{axis.upper()}RATE_FF",
            "i_limit": INTEGRAL_LIMITS[axis],
            **SHARED,
        }
        for axis in ATTITUDE_AXES
    },
    frozenset({"p", "i", "d", "ff", "i_limit"}),
)
NATIVE_POSITION = NativeLaw(
    "px4_position",
    {
        axis: dict(zip(("position_p", "p", "i", "d", "d_cutoff"), (*NAMES[axis], "MPC_VELD_LP"), strict=True))
        for axis in ("x", "z")
    },
    frozenset({"p", "i", "d"}),
)
PX4 = ParameterSet(
    target="px4",
    name=f"PX4 {VERSION}",
    file="gainproof.params",
    table=TABLE,
    names=NAMES,
    carried=frozenset({name for names in NAMES.values() for name in names[:3]} | {TILT, YAW_FILTER, LOOP_RATE}),
    scaling=(*(f"MC_{axis.upper()}RATE_K" for axis in ATTITUDE_AXES), MODEL, HOVER),
    yaw_filter=YAW_FILTER,
    gyro="IMU_GYRO_CUTOFF",
    gyro_cutoff=40.0,
    native=(NATIVE_POSITION, NATIVE_ATTITUDE),
    native_table=NATIVE_TABLE,
)


@dataclass(frozen=True)
class Px4(Autopilot):
    """PX4 on an airframe."""

    def completed(self, values: Values) -> dict[str, float]:
        """Return all parameters: by default the airframe's hover thrust and the table's defaults."""
        full = super().completed(values)
        return full if HOVER in values else full | {HOVER: hover_share(self.rotors, full[MODEL])}

    def units(self, values: Values) -> dict[str, float]:
        """Return the unit of PX4's inner P in ours [1/s], by axis; values: complete."""
        slope = command_slope(self.rotors, values[MODEL])
        horizontal = self.vehicle.gravity / GRAVITY
        vertical = horizontal * slope * values[HOVER] / self.rotors.hover_thrust
        torques = torque_scale(self.rotors, px4_factors(self.rotors), slope, "PX4")
        turning = {
            axis: values[f"MC_{axis.upper()}RATE_K"] * torque / inertia
            for axis, inertia, torque in zip(ATTITUDE_AXES, self.vehicle.inertia, torques, strict=True)
        }
        return turning | {"x": horizontal, "z": vertical}

    def tilt_limit(self, values: Values) -> tuple[float, str]:
        """Return the largest tilt [rad] and the parameter that it comes from."""
        return radians(values[TILT]), TILT

    def written_tilt(self, limit: float, present: Values | None) -> dict[str, float]:
        """Return the largest tilt [deg]; unchanged where ours [rad] follows from the vehicle's."""
        present_tilt = None if present is None else present.get(TILT)
        same = present_tilt is not None and abs(held_tilt(radians(present_tilt)) - limit) <= SAME * limit
        return {TILT: present_tilt if present_tilt is not None and same else degrees(limit)}

    def switched_off(self, settings: Mapping[str, str]) -> dict[str, float]:
        """Return PX4's other parameters at values with which it flies our loops."""
        model = 0.0 if settings[THRUST_MODEL] == "local" else linearizing_model(self.rotors)
        rates = {
            f"MC_{axis.upper()}RATE_{term}": float(term == "K") for axis in ATTITUDE_AXES for term in ("D", "FF", "K")
        }
        velocities = {"MPC_XY_VEL_D_ACC": 0.0, "MPC_Z_VEL_D_ACC": 0.0}
        thrust = {MODEL: model, HOVER: hover_share(self.rotors, model)}
        return rates | dict.fromkeys(INTEGRAL_LIMITS.values(), 1.0) | velocities | {"MC_YAW_WEIGHT": 1.0} | thrust

    def chosen(self, settings: Mapping[str, str], unchanged: dict[str, float]) -> dict[str, float]:
        """Return a vehicle's unchanged parameters, with the thrust model of the options."""
        if settings[THRUST_MODEL] == "vehicle":
            return unchanged
        off = self.switched_off(settings)
        return unchanged | {name: off[name] for name in (MODEL, HOVER)}

    def check(self, values: Values) -> None:
        """Refuse nothing: PX4 arms with any parameters in their ranges."""

    def written(self, values: Values, settings: Mapping[str, str], comments: Sequence[str]) -> bytes:
        """Return the content of a parameter file: for the option's MAVLink id."""
        return write_params(values, whole_number(settings, "vehicle", 1, 255), comments)
