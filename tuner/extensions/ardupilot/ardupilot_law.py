"""ArduPilot Copter: angle P around a rate PID with filters on the target, the error and the derivative of the error.

    w_sp = LP_t(angle_p (r - y) + r'),    w = LP(y'),    e = LP_e(w_sp - w)
    b0 u = authority output,    output = p e + I + d LP_d(e') + ff w_sp,    I' = i e,    |I| <= i_limit

Use it for a vehicle that flies ArduPilot: the gains are its parameters, which `tuner import` reads and `tuner export` writes.

output is ArduPilot's normalised torque, `authority` the angular acceleration that a unit of it gives the vehicle, so that p, i,
d and ff are ATC_RAT_*_P, _I, _D and _FF. I is in force in the period in which it is formed and only shrinks while the motors
are at a limit. Not here: the square root of large angle errors, input shaping, the slew limiter SMAX, notches. The gyro's
filter is sampled with the loop, the firmware's with the gyro. ArduPilot Copter 4.6: libraries/AC_PID/AC_PID.cpp,
AC_AttitudeControl, AP_InertialSensor.
"""

from collections.abc import Mapping
from typing import NamedTuple

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.filters import Delays, Section, low_pass, settled_section, stage_share, step_section, step_stage
from plant.laws.law import Blocks, Law, Span
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.cascade import ATTITUDE_AXES
from plant.quadrotor.vehicle import Vehicle
from tuner.extensions.autopilots.law_parts import gain_rows, limited, shrinking_only
from tuner.extensions.autopilots.scales import accelerations, ardupilot_factors, linearized_slope

SOURCE = "ArduPilot Copter 4.6, libraries/AC_PID/AC_PID.cpp and parameter metadata"


class Gains(NamedTuple):
    """angle_p [1/s]; p [s/y], i [1/y], d [s2/y], ff [s/y], i_limit [1]: of the normalised output; target_cutoff, error_cutoff,
    d_cutoff, gyro_cutoff [Hz], 0 for none; authority [y/s2]: acceleration that a unit of output gives.
    """

    angle_p: float
    p: float
    i: float
    d: float
    ff: float
    i_limit: float
    target_cutoff: float
    error_cutoff: float
    d_cutoff: float
    gyro_cutoff: float
    authority: float


class Constants(NamedTuple):
    """Gains, with filters as shares of a new sample and a section."""

    angle_p: float
    p: float
    i: float
    d: float
    ff: float
    i_limit: float
    target: float
    error: float
    derivative: float
    gyro: Section
    authority: float


class Memory(NamedTuple):
    """integral [1]; target, error [y/s] and derivative [y/s2] behind their filters; what the gyro's filter keeps."""

    integral: float
    target: float
    error: float
    derivative: float
    gyro: Delays


def prepare(gains: Gains, h: float) -> Constants:
    """Sample the filters."""
    return Constants(
        gains.angle_p,
        gains.p,
        gains.i,
        gains.d,
        gains.ff,
        gains.i_limit,
        stage_share(gains.target_cutoff, h),
        stage_share(gains.error_cutoff, h),
        stage_share(gains.d_cutoff, h),
        low_pass(gains.gyro_cutoff, h),
        gains.authority,
    )


def start(constants: Constants, measured: Measured, held: float) -> Memory:
    """Steady: the integral holds the plant, the gyro's filter is settled at the measured rate."""
    gyro = settled_section(measured.rate, constants.gyro)
    return Memory(held / constants.authority, 0.0, -measured.rate, 0.0, gyro)


def step(
    memory: Memory,
    constants: Constants,
    channel: Channel,
    setpoint: Setpoint,
    measured: Measured,
    applied: Applied,
    h: float,
) -> tuple[float, Memory]:
    """One control period; the integral takes effect at once."""
    rate, kept_gyro = step_section(memory.gyro, measured.rate, constants.gyro)
    rate_setpoint = constants.angle_p * (setpoint.value - measured.value) + setpoint.rate
    target = step_stage(memory.target, rate_setpoint, constants.target)
    error = step_stage(memory.error, target - rate, constants.error)
    derivative = step_stage(memory.derivative, (error - memory.error) / h, constants.derivative)
    integrated = shrinking_only(error, memory.integral, channel.b0 * applied.excess, constants.authority)
    integral = limited(memory.integral + h * constants.i * integrated, constants)
    output = constants.p * error + integral + constants.d * derivative + constants.ff * target
    return constants.authority * output / channel.b0, Memory(integral, target, error, derivative, kept_gyro)


def on_airframe(vehicle: Vehicle) -> Mapping[str, Mapping[str, float]]:
    """Return the authority about each axis, with thrust linearised (MOT_THST_EXPO)."""
    rotors = actuation(vehicle)
    return {
        "authority": accelerations(rotors, ardupilot_factors(rotors), linearized_slope(rotors), vehicle, "ArduPilot")
    }


row = gain_rows(SOURCE)

LAW = Law(
    name="ardupilot",
    title="ArduPilot: angle P, rate PID, filters of target, error, D and gyro",
    blocks=Blocks("angle P, rate PID", measured="low-pass"),
    source=SOURCE,
    Gains=Gains,
    Constants=Constants,
    Memory=Memory,
    prepare=prepare,
    start=start,
    step=step,
    gains=(
        row("angle_p", "ATC_ANG_*_P", Span(4.5, 3.0, 12.0), Span(1.0, 0.3, 4.0)),
        row("p", "ATC_RAT_*_P", Span(0.135, 0.01, 0.5), Span(2.0, 0.1, 6.0)),
        row("i", "ATC_RAT_*_I", Span(0.135, 0.01, 2.0), Span(1.0, 0.05, 3.0)),
        row(
            "d", "ATC_RAT_*_D", Span(0.0036, 0.0, 0.05), Span(0.02, 0.0, 0.5),
            meaning="normalised torque per derivative of the rate error",
        ),
        row("ff", "ATC_RAT_*_FF", Span(0.0, 0.0, 0.5)),
        row("i_limit", "ATC_RAT_*_IMAX", Span(0.5, 0.05, 1.0), Span(10.0, 1.0, 20.0)),
        row(
            "target_cutoff", "ATC_RAT_*_FLTT", Span(20.0, 5.0, 100.0), Span(0.0, 0.0, 50.0),
            meaning="cut-off of the first-order low-pass on the rate asked for, 0 for none", unit="Hz",
        ),
        row(
            "error_cutoff", "ATC_RAT_*_FLTE", Span(0.0, 0.0, 100.0), Span(0.0, 0.0, 50.0),
            meaning="cut-off of the first-order low-pass on the rate error, 0 for none", unit="Hz",
        ),
        row(
            "d_cutoff", "ATC_RAT_*_FLTD", Span(20.0, 5.0, 100.0), Span(5.0, 0.0, 50.0),
            meaning="cut-off of the first-order low-pass on the derivative, 0 for none", unit="Hz",
        ),
        row("gyro_cutoff", "INS_GYRO_FILTER", Span(20.0, 10.0, 120.0), Span(0.0, 0.0, 40.0)),
        row("authority", "authority", Span(50.0, 1.0, 2000.0), Span(1.0, 0.5, 2.0)),
    ),
    sampling="low-passes: backward Euler, the gyro's bilinear; D: backward difference; integral: forward Euler, in force at once",
    promises=frozenset({"rejects"}),
    limits=(limited,),
    shared={"gyro_cutoff": ATTITUDE_AXES},
    axes={
        "yaw": {
            "p": Span(0.18, 0.1, 2.5),
            "i": Span(0.018, 0.01, 1.0),
            "d": Span(0.0, 0.0, 0.02),
            "target_cutoff": Span(20.0, 1.0, 50.0),
            "error_cutoff": Span(2.5, 0.0, 20.0),
            "d_cutoff": Span(20.0, 1.0, 50.0),
        },
    },
    on_airframe=on_airframe,
)  # fmt: skip
